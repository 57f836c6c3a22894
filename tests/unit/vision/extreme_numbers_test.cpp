/// Numbers that are no measurements: the tracker says what is wrong, or goes on.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>

#include "synthetic_view.h"
#include "vir/vision/feature_tracker.h"
#include "vir_test_extremes.h"

namespace vir::vision {
namespace {

using test::extremes;
using test::lookingDown;
using test::smallCamera;
using test::SyntheticPlane;

class ExtremeNumbers : public testing::Test {
 protected:
  cv::Mat view(int i) const {
    return plane_.render(*camera_, lookingDown(Vec3(0.02 * i, 0.01 * i, 2.0), Vec3(0.1, 0, 0)));
  }
  static void expectNumbers(const TrackedFrame& frame) {
    for (const FeatureObservation& f : frame.features) {
      EXPECT_TRUE(f.px.allFinite() && f.bearing.allFinite() && f.dpx_dbearing.allFinite());
      EXPECT_TRUE(f.bearing_rate.allFinite()) << f.bearing_rate.transpose();
    }
    for (const double d : {frame.median_flow_px, frame.median_parallax_px, frame.mean_intensity}) {
      EXPECT_TRUE(std::isfinite(d));
    }
  }

  const SyntheticPlane plane_;
  const std::shared_ptr<const camera::CameraModel> camera_ = camera::makeCamera(smallCamera());
  const cv::Mat first_ = view(0), second_ = view(1);
};

TEST_F(ExtremeNumbers, TurnsThatAreNone) {
  for (const double value : extremes()) {
    for (int i = 0; i < 10; ++i) {
      FeatureTracker tracker(TrackerOptions(), camera_);
      tracker.process(0, first_, Mat3::Identity());
      Mat3 R = Mat3::Identity();
      if (i < 9) R(i / 3, i % 3) = value;
      if (i == 9) R.setConstant(value);
      SCOPED_TRACE(testing::Message() << value << " at " << i);
      const TrackedFrame frame = tracker.process(50'000'000, second_, R);
      EXPECT_TRUE(frame.usable);
      EXPECT_GT(frame.continued, 10);
      expectNumbers(frame);
    }
  }
}

TEST_F(ExtremeNumbers, RatesOfTurning) {
  test::forExtremeVectors(Vec3(0.01, 0, 0), [this](const Vec3& rate) {
    FeatureTracker tracker(TrackerOptions(), camera_);
    tracker.process(0, first_, Mat3::Identity());
    SCOPED_TRACE(testing::Message() << rate.transpose());
    const TrackedFrame frame = tracker.processTurning(50'000'000, second_, rate);
    EXPECT_TRUE(frame.usable);
    expectNumbers(frame);
    // And the next image is followed again.
    expectNumbers(tracker.process(100'000'000, view(2), Mat3::Identity()));
  });
}

TEST_F(ExtremeNumbers, Stamps) {
  for (const TimeNs t : {INT64_MIN, TimeNs(-1), TimeNs(0), TimeNs(1), INT64_MAX}) {
    FeatureTracker tracker(TrackerOptions(), camera_);
    tracker.process(0, first_, Mat3::Identity());
    SCOPED_TRACE(t);
    expectNumbers(tracker.process(t, second_, Mat3::Identity()));
  }
}

/// Refused, or taken and worked with.
TEST_F(ExtremeNumbers, Options) {
  using Member = double TrackerOptions::*;
  for (const Member member : {&TrackerOptions::min_distance_px,
                              &TrackerOptions::forward_backward_px, &TrackerOptions::outlier_px,
                              &TrackerOptions::min_corner_score, &TrackerOptions::min_similarity}) {
    for (const double value : extremes()) {
      TrackerOptions options;
      options.*member = value;
      try {
        FeatureTracker tracker(options, camera_);
        tracker.process(0, first_, Mat3::Identity());
        expectNumbers(tracker.process(50'000'000, second_, Mat3::Identity()));
        EXPECT_TRUE(std::isfinite(value));
      } catch (const std::invalid_argument&) {
      }
    }
  }
  using Whole = int TrackerOptions::*;
  for (const Whole member :
       {&TrackerOptions::max_tracks, &TrackerOptions::grid_cell_px, &TrackerOptions::pyramid_levels,
        &TrackerOptions::window_px, &TrackerOptions::patch_px, &TrackerOptions::max_iterations}) {
    for (const int value : {INT32_MIN, -1, 0, 1, 2, 1000000, INT32_MAX}) {
      TrackerOptions options;
      options.*member = value;
      try {
        FeatureTracker tracker(options, camera_);
        tracker.process(0, first_, Mat3::Identity());
        expectNumbers(tracker.process(50'000'000, second_, Mat3::Identity()));
        EXPECT_GE(value, 0);
      } catch (const std::invalid_argument&) {
      }
    }
  }
}

}  // namespace
}  // namespace vir::vision
