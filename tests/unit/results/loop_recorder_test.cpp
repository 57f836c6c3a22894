#include "loop_recorder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(LoopRecorder, WritesWhatWasDecided) {
  const test::TempFolder folder;
  const ResultsFolder results((folder / "out").string());
  LoopRecorder recorder(results);
  StampedPose pose;
  for (const TimeNs t : {1000000000LL, 2000000000LL, 2000000000LL, 1500000000LL}) {
    pose.t = t;
    recorder.add(pose);
  }
  pose.t = 3000000000LL;
  pose.T_W_B.p.x() = kNan;
  recorder.add(pose);
  LoopRecord accepted;
  accepted.t_older = 1000000000LL;
  accepted.t_newer = 9000000000LL;
  accepted.accepted = true;
  accepted.decision = "accepted";
  accepted.chi2 = 3.25;
  accepted.matches = 40;
  accepted.inliers = 30;
  LoopRecord refused;
  refused.decision = "refused";
  refused.T_older_newer.p.x() = kNan;
  const auto counts = recorder.finish(std::vector<LoopRecord>{accepted, refused});
  ASSERT_TRUE(counts);
  EXPECT_EQ(counts->first, 1);
  EXPECT_EQ(counts->second, 1);
  EXPECT_EQ(recorder.records().size(), 2u);
  const std::string odometry = test::readText(results.file("trajectory_odom.tum"));
  EXPECT_EQ(std::count(odometry.begin(), odometry.end(), '\n'), 2);
  const std::string loops = test::readText(results.file("loops.csv"));
  EXPECT_NE(loops.find("9.000000000,1.000000000,0,1,accepted,3.250,40,30,0,0,0,0,0,0,0,0,0,0,0,0"),
            std::string::npos)
      << loops;
  EXPECT_NE(loops.find(",0,0,refused,,0,0,"), std::string::npos) << loops;
  EXPECT_EQ(loops.find("nan"), std::string::npos);
}

TEST(LoopRecorder, WithoutLoopsThereIsNoFile) {
  const test::TempFolder folder;
  const ResultsFolder results((folder / "out").string());
  LoopRecorder recorder(results);
  EXPECT_FALSE(recorder.finish(std::nullopt));
  EXPECT_FALSE(std::filesystem::exists(results.file("loops.csv")));
  EXPECT_FALSE(std::filesystem::exists(results.file("trajectory_odom.tum")));
}

}  // namespace
}  // namespace vir::results
