/// Pairs of images: taken apart by the reader, split from one image, put together for a rawlog.
#include "vir/rawlog/stereo_images.h"

#include <gtest/gtest.h>

#include <limits>

#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

using mrpt::obs::CObservation;
using mrpt::obs::CObservationImage;
using mrpt::obs::CObservationStereoImages;
using test::imageAt;
using test::kMs;
using test::kStart;

/// Two cameras 11 cm apart that look ahead, turned against each other.
CObservationStereoImages::Ptr pairAt(TimeNs t, const std::string& label = "CAM0") {
  const auto left = imageAt(t, 10), right = imageAt(t, 20);
  left->sensorLabel = label;
  left->cameraParams.setIntrinsicParamsFromValues(100, 101, 8, 6);
  right->cameraParams.setIntrinsicParamsFromValues(102, 103, 8.5, 6.5);
  left->cameraPose = mrpt::poses::CPose3D(0.1, 0.2, 0.3, -1.5, 0.1, -1.6);
  right->cameraPose = left->cameraPose + mrpt::poses::CPose3D(0.11, 0.001, 0, 0.02, 0, 0.01);
  return pairOf(*left, *right);
}

std::vector<CObservation::Ptr> readBack(const std::vector<CObservation::Ptr>& all,
                                        std::string* refusals = nullptr) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  RawlogWriter writer(path);
  for (const auto& o : all) writer.write(*o);
  writer.finish();
  RawlogReader reader(path);
  std::vector<CObservation::Ptr> out;
  while (const auto o = reader.next()) out.push_back(o);
  EXPECT_EQ(reader.damage(), "");
  if (refusals != nullptr) *refusals = reader.refusals();
  return out;
}

const CObservationImage& image(const CObservation::Ptr& o) {
  return dynamic_cast<const CObservationImage&>(*o);
}

TEST(StereoImages, APairComesOutAsTheImagesOfTwoCameras) {
  const auto all = readBack({pairAt(kStart), test::imuAt(kStart + kMs)});
  ASSERT_EQ(all.size(), 3u);
  const CObservationImage &left = image(all[0]), &right = image(all[1]);
  EXPECT_EQ(left.sensorLabel, "CAM0");
  EXPECT_EQ(right.sensorLabel, "CAM1");
  EXPECT_EQ(fromMrptTime(left.timestamp), kStart);
  EXPECT_EQ(fromMrptTime(right.timestamp), kStart);
  EXPECT_EQ(left.image.at<std::uint8_t>(0, 0), 10);
  EXPECT_EQ(right.image.at<std::uint8_t>(0, 0), 20);
  EXPECT_EQ(left.cameraParams.fx(), 100);
  EXPECT_EQ(right.cameraParams.fy(), 103);
  const mrpt::poses::CPose3D T_B_L(0.1, 0.2, 0.3, -1.5, 0.1, -1.6);
  const mrpt::poses::CPose3D T_B_R = T_B_L + mrpt::poses::CPose3D(0.11, 0.001, 0, 0.02, 0, 0.01);
  for (const auto& [got, wanted] :
       {std::pair{left.cameraPose, T_B_L}, std::pair{right.cameraPose, T_B_R}}) {
    const Pose a = fromMrptPose(got), b = fromMrptPose(wanted);
    EXPECT_LT((a.p - b.p).norm(), 1e-9);
    EXPECT_LT((a.R() - b.R()).norm(), 1e-9);
  }
}

TEST(StereoImages, APairWithoutItsRightImageIsOneImage) {
  const auto pair = pairAt(kStart);
  pair->hasImageRight = false;
  const auto all = readBack({pair});
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0]->sensorLabel, "CAM0");
}

TEST(StereoImages, EachPairOfCamerasHasLabelsOfItsOwn) {
  PairNames names;
  EXPECT_EQ(names.of("BUMBLEBEE").left, "CAM0");
  EXPECT_EQ(names.of("REAR").right, "CAM3");
  EXPECT_EQ(names.of("BUMBLEBEE").right, "CAM1");
  EXPECT_EQ(names.of("CAM6").left, "CAM6");
  EXPECT_EQ(names.of("CAM6").right, "CAM7");
  EXPECT_EQ(PairNames().of("CAM").left, "CAM0");
}

TEST(StereoImages, APlaceThatIsNoPoseIsLeftOutAndSaid) {
  const auto no_number = pairAt(kStart), no_rotation = pairAt(kStart + kMs);
  no_number->cameraPose.x(std::numeric_limits<double>::quiet_NaN());
  no_rotation->rightCameraPose.quat().r(7);
  std::string refusals;
  const auto all = readBack({no_number, no_rotation, pairAt(kStart + 2 * kMs)}, &refusals);
  EXPECT_EQ(all.size(), 2u);
  EXPECT_NE(refusals.find("1 observations left out of CAM0: the place of the left"),
            std::string::npos)
      << refusals;
  EXPECT_NE(refusals.find("the place of the right camera of a pair is no pose"), std::string::npos)
      << refusals;
}

TEST(StereoImages, AnImageOfTwoViewsIsCutInTwo) {
  const auto wide = imageAt(kStart, 5);
  *wide->image.ptr<std::uint8_t>(8, 11) = 9;
  const auto halves = halvesOf(*wide, {"CAM0", "CAM1"});
  ASSERT_EQ(halves.size(), 2u);
  EXPECT_EQ(halves[0]->image.getWidth(), 8u);
  EXPECT_EQ(halves[1]->image.getHeight(), 12u);
  EXPECT_EQ(halves[0]->image.at<std::uint8_t>(0, 0), 5);
  EXPECT_EQ(halves[1]->image.at<std::uint8_t>(0, 0), 0);
  EXPECT_EQ(halves[1]->image.at<std::uint8_t>(0, 11), 9);
  EXPECT_EQ(halves[1]->sensorLabel, "CAM1");
  EXPECT_EQ(halves[1]->timestamp, wide->timestamp);
  wide->image.resize(15, 12, mrpt::img::CH_GRAY);
  EXPECT_THROW(halvesOf(*wide, {"CAM0", "CAM1"}), std::invalid_argument);
}

TEST(StereoImages, ImagesOfOneStampArePutTogetherAndTheRestGoesThrough) {
  PairJoiner joiner({"CAM0", "CAM1"});
  const auto right = [](TimeNs t) {
    auto o = imageAt(t, 20);
    o->sensorLabel = "CAM1";
    return o;
  };
  std::vector<CObservation::Ptr> out;
  const auto add = [&](const CObservation::Ptr& o) {
    for (const auto& done : joiner.add(o)) out.push_back(done);
  };
  add(right(kStart));  // in either order
  add(test::imuAt(kStart));
  add(imageAt(kStart, 10));
  add(imageAt(kStart + kMs, 11));  // the right one is missing
  add(right(kStart + 2 * kMs));    // the left one is
  for (const auto& done : joiner.finish()) out.push_back(done);
  ASSERT_EQ(out.size(), 4u);
  EXPECT_EQ(joiner.pairs(), 1);
  EXPECT_EQ(joiner.single(), 2);
  const auto pair = std::dynamic_pointer_cast<CObservationStereoImages>(out[1]);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->imageRight.at<std::uint8_t>(0, 0), 20);
  EXPECT_TRUE(std::dynamic_pointer_cast<CObservationImage>(out[3]));
  for (std::size_t k = 1; k < out.size(); ++k) EXPECT_LE(out[k - 1]->timestamp, out[k]->timestamp);
}

}  // namespace
}  // namespace vir::rawlog
