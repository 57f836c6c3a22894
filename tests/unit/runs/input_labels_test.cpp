/// Recordings under labels of their own.
#include "vir/runs/input_labels.h"

#include <gtest/gtest.h>

#include "vir/rawlog/labels.h"
#include "vir/roles/range_labels.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::runs {
namespace {

using roles::EstimatorInput;
using roles::InputKind;

class MatchLabels : public testing::Test {
 protected:
  void SetUp() override { test::writeRecording(rawlog_, 10); }
  InputLabels match(const std::vector<EstimatorInput>& inputs) {
    return matchLabels(inputs, rawlog_);
  }
  test::TempFolder folder_;
  const std::string rawlog_ = (folder_ / "a.rawlog").string();
};

TEST_F(MatchLabels, NothingToDoWhereLabelsAreAsAsked) {
  const InputLabels l = match({{InputKind::image, rawlog::kCameraLabel, 1},
                               {InputKind::tracks, rawlog::kTracksLabel, 1},
                               {InputKind::imu, rawlog::kImuLabel, 2}});
  EXPECT_TRUE(l.as.empty());
  EXPECT_TRUE(l.notes.empty()) << l.notes.front();
}

TEST_F(MatchLabels, TakesTheOnlyOnesOfTheirKindAndSaysSo) {
  const InputLabels l = match({{InputKind::image, "front", 1}, {InputKind::imu, "body_imu", 2}});
  EXPECT_EQ(l.as, (std::map<std::string, std::string>{{rawlog::kCameraLabel, "front"},
                                                      {rawlog::kImuLabel, "body_imu"}}));
  ASSERT_EQ(l.notes.size(), 2u);
  EXPECT_EQ(l.notes[0], "no images under the label front: the only ones, under CAM0, are taken");
}

TEST_F(MatchLabels, TakesNothingThatIsNotNeeded) {
  // The ground truth is a pose too, and never an input.
  const InputLabels l = match({{InputKind::imu, rawlog::kImuLabel, 1},
                               {InputKind::image, "front", 0},
                               {InputKind::pose, "wheels", 0}});
  EXPECT_TRUE(l.as.empty());
  ASSERT_EQ(l.notes.size(), 1u);
  EXPECT_NE(l.notes[0].find("those under CAM0 are not used"), std::string::npos) << l.notes[0];
}

TEST_F(MatchLabels, RangesOfFurtherAntennasAreSaid) {
  {
    rawlog::RawlogWriter writer(rawlog_);
    for (int i = 0; i < 4; ++i) {
      const auto range = test::rangeAt(test::kStart + i * test::kMs, 7);
      range->sensorLabel = i % 2 == 0 ? "UWB0" : "UWB1";
      writer.write(*range);
    }
    writer.finish();
  }
  const InputLabels one = match({{InputKind::ranges, rawlog::kRangeLabel, 0}});
  EXPECT_TRUE(one.as.empty());
  ASSERT_EQ(one.notes.size(), 1u);
  EXPECT_NE(one.notes[0].find("range_label = UWB0 UWB1"), std::string::npos) << one.notes[0];
  std::vector<EstimatorInput> both;
  roles::addRangeInputs("UWB0  UWB1", &both);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[1].label, "UWB1");
  EXPECT_TRUE(match(both).notes.empty());
  EXPECT_TRUE(roles::isAmong("UWB1", "UWB0 UWB1"));
  EXPECT_FALSE(roles::isAmong("UWB", "UWB0 UWB1"));
}

TEST_F(MatchLabels, ImagesOfFurtherCamerasAreSaid) {
  {
    rawlog::RawlogWriter writer(rawlog_);
    for (int i = 0; i < 4; ++i) {
      const auto image = test::imageAt(test::kStart + i * test::kMs);
      image->sensorLabel = i % 2 == 0 ? "CAM0" : "CAM1";
      writer.write(*image);
    }
    writer.finish();
  }
  const EstimatorInput first{InputKind::image, "CAM0", 1};
  const InputLabels one = match({first});
  ASSERT_EQ(one.notes.size(), 1u);
  EXPECT_NE(one.notes[0].find("other_cameras = CAM1"), std::string::npos) << one.notes[0];
  EXPECT_TRUE(match({first, {InputKind::image, "CAM1", 0}}).notes.empty());
  // Named, and not there: said with what is there; not said of those that nobody has named.
  for (const char* label : {"CAM2", "cam1"}) {
    const InputLabels none = match({first, {InputKind::image, label, 0, true}});
    ASSERT_EQ(none.notes.size(), 2u);
    EXPECT_EQ(none.notes[1], "[Estimator] other_cameras: there are no images under " +
                                 std::string(label) +
                                 " at the beginning of the recording; there are images under CAM0, "
                                 "CAM1 (name labels as they are there, with blanks between them)");
  }
  const InputLabels two =
      match({first, {InputKind::image, "CAM1", 0, true}, {InputKind::image, "CAM2", 0, true}});
  ASSERT_EQ(two.notes.size(), 1u);
  EXPECT_NE(two.notes[0].find("no images under CAM2 at"), std::string::npos) << two.notes[0];
  EXPECT_TRUE(
      match({first, {InputKind::image, "CAM1", 0}, {InputKind::image, "CAM2", 0}}).notes.empty());
}

TEST_F(MatchLabels, AnotherInputOfTheGroupDoes) {
  const InputLabels l =
      match({{InputKind::image, "front", 1}, {InputKind::imu, rawlog::kImuLabel, 1}});
  EXPECT_TRUE(l.as.empty());
  EXPECT_TRUE(l.notes.empty());
}

}  // namespace
}  // namespace vir::runs
