/// Can the result of a run be trusted?
#include <gtest/gtest.h>

#include "vir/results/run_recorder.h"

namespace vir::results {
namespace {

/// 60 s with a pose for every image but those of the first second.
RunSummary good() {
  RunSummary s;
  s.frames = 1200;
  s.poses = 1180;
  s.init_time_s = 1;
  s.duration_s = 60;
  return s;
}

RunSummary filled(RunSummary s) {
  fillVerdict(&s);
  return s;
}

bool doubts(const RunSummary& s, const std::string& part) {
  return s.doubts.size() == 1 && s.doubts[0].find(part) != std::string::npos;
}

TEST(VerdictOfARun, GoodWithoutDoubts) {
  const RunSummary s = filled(good());
  EXPECT_EQ(s.verdict, Verdict::good);
  EXPECT_TRUE(s.doubts.empty());
}

TEST(VerdictOfARun, ADoubtOfTheEstimatorIsOneOfTheRun) {
  RunSummary s = good();
  s.doubts = {"the sights contradict each other"};
  EXPECT_EQ(filled(s).verdict, Verdict::doubtful);
}

TEST(VerdictOfARun, CausesAreLookedForWhereTheResultCannotBeTrustedAndOnlyThere) {
  int asked = 0;
  const auto explain = [&] {
    ++asked;
    return std::vector<std::string>{"the camera hangs upside down", "noise is larger than given"};
  };
  RunSummary s = good();
  fillVerdict(&s, explain);
  EXPECT_EQ(asked, 0);
  s = good();
  s.doubts = {"few tracks fit the motion"};
  s.likely_causes = {"noise is larger than given", "two gaps"};
  fillVerdict(&s, explain);
  EXPECT_EQ(asked, 1);
  const std::vector<std::string> expected = {"the camera hangs upside down",
                                             "noise is larger than given", "two gaps",
                                             "few tracks fit the motion"};
  EXPECT_EQ(s.doubts, expected);
  s = good();
  s.unusable_input = {"the camera hangs upside down"};
  fillVerdict(&s, explain);
  EXPECT_EQ(s.verdict, Verdict::doubtful);
  const std::vector<std::string> once = {"noise is larger than given",
                                         "the camera hangs upside down"};
  EXPECT_EQ(s.doubts, once);
}

TEST(VerdictOfARun, WhatTheInputShowsExplainsOtherDoubtsAndComesFirst) {
  RunSummary s = good();
  s.likely_causes = {"the accelerometer is negated"};
  EXPECT_EQ(filled(s).verdict, Verdict::good) << "a cause without an effect";
  EXPECT_TRUE(filled(s).doubts.empty());
  s.doubts = {"few tracks fit the motion"};
  const RunSummary explained = filled(s);
  EXPECT_EQ(explained.verdict, Verdict::doubtful);
  EXPECT_EQ(explained.doubts, (std::vector<std::string>{"the accelerometer is negated",
                                                        "few tracks fit the motion"}));
}

TEST(VerdictOfARun, ASensorWhoseDataAreUselessIsADoubt) {
  RunSummary s = good();
  s.unusable_input = {"the ranges are in millimetres"};
  EXPECT_EQ(filled(s).verdict, Verdict::doubtful);
  EXPECT_TRUE(doubts(filled(s), "the ranges are in millimetres"));
}

/// Half of a recording that cannot be used, and a path from the other half.
TEST(VerdictOfARun, ALargeShareLeftOutIsADoubt) {
  RunSummary s = good();
  s.counters = {{"images", 1200}, {"imu_readings", 6000}, {"imu_spikes", 1000}};
  s.left_out = {{kImages, 250}, {kImuReadings, 400}};
  EXPECT_EQ(filled(s).verdict, Verdict::good);
  s.left_out[kImages] = 1200;
  EXPECT_EQ(filled(s).verdict, Verdict::doubtful);
  EXPECT_TRUE(doubts(filled(s), "1200 of 2400 images could not be used"));
  s.left_out = {{kImuReadings, 900}};
  EXPECT_TRUE(doubts(filled(s), "1900 of 7900 readings of the IMU could not be used"));
  s.left_out.clear();
  s.counters.emplace_back("images_unusable", 300);
  EXPECT_TRUE(doubts(filled(s), "300 of 1200 images could not be used"));
  s.counters = {{"odometry_poses", 100}, {"odometry_not_finite", 50}};
  EXPECT_TRUE(doubts(filled(s), "50 of 100 poses of the odometry could not be used"));
  s.counters.clear();
  s.ranges_accepted = 100;
  s.ranges_rejected = 60;  // by the gate, which is another matter
  s.left_out = {{kRanges, 40}};
  EXPECT_EQ(filled(s).verdict, Verdict::good);
  s.left_out = {{kRanges, 41}};
  EXPECT_TRUE(doubts(filled(s), "41 of 201 ranges could not be used"));
}

TEST(VerdictOfARun, OdometryThatPausedOrJumpedIsADoubt) {
  RunSummary s = good();
  s.counters = {{"odometry_gaps", 0}, {"odometry_jumps", 0}};
  EXPECT_EQ(filled(s).verdict, Verdict::good);
  s.counters = {{"odometry_gaps", 2}, {"odometry_jumps", 0}};
  EXPECT_EQ(filled(s).verdict, Verdict::doubtful);
  EXPECT_TRUE(doubts(filled(s), "paused (2)"));
  s.counters = {{"odometry_jumps", 1}};
  EXPECT_TRUE(doubts(filled(s), "jumped (1)"));
}

TEST(VerdictOfARun, AnErrorIsNamedWhereThereIsNoPoseEither) {
  RunSummary s = good();
  s.poses = 0;
  s.error = "the disk is full";
  EXPECT_EQ(filled(s).verdict, Verdict::lost);
  EXPECT_EQ(filled(s).doubts.size(), 2u);
  EXPECT_NE(filled(s).doubts[0].find("the disk is full"), std::string::npos);
}

TEST(VerdictOfARun, ALateStart) {
  RunSummary s = good();
  s.init_time_s = 7.9;
  s.poses = 1040;
  EXPECT_EQ(filled(s).verdict, Verdict::good);
  s.init_time_s = 8.1;
  s.longest_wait_reason = "too little parallax";
  EXPECT_EQ(filled(s).verdict, Verdict::doubtful);
  EXPECT_TRUE(doubts(filled(s), "no pose in the first 8.1 s of 60.0 s: too little parallax"));
}

TEST(VerdictOfARun, PosesForTooFewImages) {
  RunSummary s = good();
  s.poses = 1070;
  EXPECT_EQ(filled(s).verdict, Verdict::good);
  s.poses = 1050;
  EXPECT_TRUE(doubts(filled(s), "poses for 89 % of the images after the first pose only (1050)"));
  EXPECT_EQ(filled(s).verdict, Verdict::doubtful);
  s.poses = 350;
  EXPECT_EQ(filled(s).verdict, Verdict::lost);
}

TEST(VerdictOfARun, NoPoseSaysWhyAndWhatToDo) {
  RunSummary s = good();
  s.poses = 0;
  s.init_time_s.reset();
  EXPECT_EQ(filled(s).verdict, Verdict::lost);
  EXPECT_TRUE(doubts(filled(s), "no pose at all: nothing to start from; `vir-slam check`"));
  s.longest_wait_reason = "rotation only";
  EXPECT_TRUE(doubts(filled(s), "no pose at all: rotation only;"));
  s.frames = 0;
  EXPECT_EQ(filled(s).verdict, Verdict::lost);
}

TEST(VerdictOfARun, AnErrorOnTheWay) {
  RunSummary s = good();
  s.error = "the disk is full";
  EXPECT_EQ(filled(s).verdict, Verdict::doubtful);
  EXPECT_TRUE(doubts(filled(s), "the run ended early: the disk is full"));
}

}  // namespace
}  // namespace vir::results
