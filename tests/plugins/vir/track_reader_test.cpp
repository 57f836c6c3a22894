/// Feature tracks of a rawlog become what the tracker would have said, whatever they hold.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <limits>

#include "tracks_of.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir {
namespace {

using mrpt::obs::CObservationStereoImagesFeatures;

std::shared_ptr<const camera::CameraModel> camera() {
  CameraCalibration c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 400;
  c.cx = 320;
  c.cy = 240;
  c.distortion = Distortion::radtan;
  c.dist = {-0.2, 0.05, 1e-4, 2e-4, 0};
  return camera::makeCamera(c);
}

struct Pixel {
  unsigned id;
  float x, y;
};

CObservationStereoImagesFeatures tracks(double s, const std::vector<Pixel>& pixels) {
  CObservationStereoImagesFeatures o;
  o.timestamp = rawlog::toMrptTime(fromSeconds(s));
  for (const Pixel& p : pixels) {
    mrpt::obs::TStereoImageFeatures f;
    f.ID = p.id;
    f.pixels.first.x = p.x;
    f.pixels.first.y = p.y;
    o.theFeatures.push_back(f);
  }
  return o;
}

TEST(TrackReader, SameIdsBelongTogether) {
  TrackReader reader;
  const auto model = camera();
  const vision::TrackedFrame first =
      reader.read(tracks(100, {{7, 100, 80}, {3, 400, 300}}), *model);
  ASSERT_EQ(first.features.size(), 2u);
  EXPECT_EQ(first.t, 100000000000LL);
  EXPECT_EQ(first.features[0].id, 3u) << "by id";
  EXPECT_EQ(first.detected, 2);
  EXPECT_EQ(first.features[1].age, 0);
  const vision::TrackedFrame next =
      reader.read(tracks(100.05, {{7, 103, 84}, {9, 20, 20}}), *model);
  ASSERT_EQ(next.features.size(), 2u);
  EXPECT_EQ(next.continued, 1);
  EXPECT_EQ(next.lost_flow, 1);
  EXPECT_EQ(next.detected, 1);
  EXPECT_DOUBLE_EQ(next.median_flow_px, 5);
  const vision::FeatureObservation& f = next.features[0];
  EXPECT_EQ(f.age, 1);
  EXPECT_LT((f.bearing_rate - (f.bearing - first.features[1].bearing) / 0.05).norm(), 1e-9);
  Vec2 px;
  Mat23 J;
  ASSERT_TRUE(model->project(f.bearing, &px, &J));
  EXPECT_LT((px - Vec2(103, 84)).norm(), 0.01);
  EXPECT_LT((J - f.dpx_dbearing).norm(), 1e-9);
  EXPECT_TRUE(next.usable);
  EXPECT_EQ(reader.unusable(), 0);
}

TEST(TrackReader, WhatIsNoFeatureIsCounted) {
  TrackReader reader;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const vision::TrackedFrame frame = reader.read(
      tracks(1, {{1, nan, 10}, {2, 10, inf}, {3, -5, 10}, {4, 700, 10}, {5, 10, 10}, {5, 11, 11}}),
      *camera());
  ASSERT_EQ(frame.features.size(), 1u);
  EXPECT_EQ(frame.features[0].px, Vec2(10, 10));
  EXPECT_EQ(reader.unusable(), 5);
}

TEST(TrackReader, NoFeaturesAreNoImage) {
  TrackReader reader;
  const vision::TrackedFrame frame = reader.read(tracks(1, {}), *camera());
  EXPECT_FALSE(frame.usable);
  EXPECT_NE(frame.reason, "");
}

TEST(TrackReader, ARepeatedTimeIsNoMotion) {
  TrackReader reader;
  reader.read(tracks(1, {{1, 50, 50}}), *camera());
  const vision::TrackedFrame again = reader.read(tracks(1, {{1, 60, 60}}), *camera());
  ASSERT_EQ(again.features.size(), 1u);
  EXPECT_TRUE(again.features[0].bearing_rate.allFinite());
}

}  // namespace
}  // namespace vir
