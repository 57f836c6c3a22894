/// Other robots in `vir-slam run`: the transform to their worlds from what came over the air.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "robot_truth.h"
#include "vir/team/world_transform.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::quoted;
using test::readJson;

TEST(PeerRun, FindsTheOtherRobotOfTheSample) {
  const std::string folder = test::sourceDir() + "/rawlog/";
  const test::TempFolder out;
  const test::RunResult run = test::runVir(folder + "two_A.rawlog", (out / "a").string());
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.text;
  const Json transforms = readJson(out / "a" / "transforms.json");
  EXPECT_EQ(transforms["common_frame"], "this");
  ASSERT_EQ(transforms["transforms"].size(), 1u);
  const Json t = transforms["transforms"][0];
  EXPECT_EQ(t["from"], "1");
  EXPECT_EQ(t["to"], "this");
  ASSERT_EQ(t["status"], "unique") << t;
  EXPECT_GT(t["ranges_used"], 200);
  const Pose T_G_own = test::worldOf(test::truthIn(folder + "two_A.rawlog"), run.trajectory);
  const test::Deviation d =
      test::deviation(t, T_G_own.inverse() * test::toldWorld(folder + "two_B.rawlog"));
  std::printf("unique after %.1f s, offset off by %.3f m, yaw by %.2f deg\n",
              t["first_unique_s"].get<double>(), d.offset_m, d.yaw_deg);
  EXPECT_LT(d.offset_m, 0.3);
  EXPECT_LT(d.yaw_deg, 3);
  ASSERT_EQ(run.summary["peers"].size(), 1u);
  EXPECT_EQ(run.summary["peers"][0]["id"], 1);
  EXPECT_EQ(run.summary["peers"][0]["status"], "unique");
  EXPECT_EQ(run.summary["peers"][0]["ranges_without_broadcast"], 0);
  EXPECT_TRUE(test::contains(run.outcome.text, "robot 1")) << run.outcome.text;
  EXPECT_TRUE(test::contains(test::readText(out / "a" / "run.log"), "robot 1 is placed after"));
  EXPECT_TRUE(test::contains(test::readText(out / "a" / "report.html"), "Other robots"));
}

/// Where a robot flies; z up.
Vec3 pathAt(double s, double phase) {
  return {3 * std::sin(0.5 * s + phase), 2.5 * std::sin(0.8 * s + 2 * phase),
          0.8 * std::sin(0.4 * s + phase)};
}

struct Air {
  int broadcast_every = 1;  ///< of so many ranges one comes with a broadcast
  double restart_s = 1e9;   ///< then the other robot begins a new world
  team::WorldTransform T{0.7, Vec3(3, -2, 0.3)}, T_later{-1.2, Vec3(-9, 12, 0.1)};
};

/// Exact odometry at 20 Hz, ranges to robot 5 at 5 Hz with what it tells.
void writeMeeting(const std::string& path, double seconds, const Air& air) {
  rawlog::RawlogWriter writer(path);
  for (int i = 0; i < 20 * seconds; ++i) {
    const double s = 0.05 * i;
    const TimeNs t = test::kStart + 50 * i * test::kMs;
    const auto odometry = test::odometryAt(t, 0);
    const Vec3 own = pathAt(s, 0.3);
    odometry->pose.mean = mrpt::poses::CPose3D(own.x(), own.y(), own.z(), 0, 0, 0);
    odometry->pose.cov.setZero();
    writer.write(*odometry);
    if (i % 4 != 2) continue;
    const auto range = test::rangeAt(t + 10 * test::kMs, 5);
    range->sensorLabel = "PEER";
    range->stdError = 0.05F;
    const Vec3 then = pathAt(s + 0.01, 0.3), there = pathAt(s + 0.01, 1.7) + Vec3(1, 2, 0);
    range->sensedData[0].sensedDistance = static_cast<float>((then - there).norm());
    writer.write(*range);
    if ((i / 4) % air.broadcast_every != 0) continue;
    const team::WorldTransform& T = s < air.restart_s ? air.T : air.T_later;
    const Vec3 told = T.inverse() * there;
    const auto sent = test::odometryAt(t + 10 * test::kMs, 0);
    sent->sensorLabel = "PEER:5";
    sent->pose.mean = mrpt::poses::CPose3D(told.x(), told.y(), told.z(), 0, 0, 0);
    sent->pose.cov.setZero();
    for (int k = 0; k < 3; ++k) sent->pose.cov(k, k) = 1e-4;
    writer.write(*sent);
  }
  writer.finish();
}

test::Outcome runOdometry(const fs::path& rawlog, const fs::path& out,
                          const std::string& more = "") {
  return test::virSlam("run " + quoted(test::sourceDir() + "/ini/odometry_range.ini") +
                       " --rawlog " + quoted(rawlog.string()) + " --out " + quoted(out.string()) +
                       " " + more);
}

void expectTransform(const Json& t, const team::WorldTransform& wanted) {
  ASSERT_EQ(t["status"], "unique") << t;
  EXPECT_NEAR(std::remainder(t["yaw_rad"].get<double>() - wanted.yaw_rad, 2 * M_PI), 0, 0.03);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(t["t_m"][i].get<double>(), wanted.t_m[i], 0.1) << i;
}

TEST(PeerRun, CountsWhatItCannotUse) {
  const test::TempFolder folder;
  Air air;
  air.broadcast_every = 4;
  writeMeeting((folder / "a.rawlog").string(), 60, air);
  const test::Outcome outcome = runOdometry(folder / "a.rawlog", folder / "out");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  expectTransform(readJson(folder / "out" / "transforms.json")["transforms"][0], air.T);
  const Json summary = readJson(folder / "out" / "summary.json");
  EXPECT_EQ(summary["counters"]["peer_ranges"], 300);
  EXPECT_EQ(summary["counters"]["peer_ranges_without_broadcast"], 225);
  // Behind the last pose no pose follows.
  EXPECT_LE(summary["counters"]["peer_ranges_without_pose"], 1);
  EXPECT_TRUE(test::contains(summary["warnings"].dump(), "225 of 300 ranges to robot 5"))
      << summary["warnings"];
}

TEST(PeerRun, NoticesThatTheOtherOneBeganANewWorld) {
  const test::TempFolder folder;
  Air air;
  air.restart_s = 30;
  writeMeeting((folder / "a.rawlog").string(), 80, air);
  const test::Outcome outcome = runOdometry(folder / "a.rawlog", folder / "out");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  expectTransform(readJson(folder / "out" / "transforms.json")["transforms"][0], air.T_later);
  EXPECT_TRUE(test::contains(test::readText(folder / "out" / "run.log"), "started a new world"));
}

TEST(PeerRun, TwiceTheSameAndNotAtAllIfNotWanted) {
  const test::TempFolder folder;
  writeMeeting((folder / "a.rawlog").string(), 40, {});
  for (const char* out : {"one", "two"}) {
    ASSERT_EQ(runOdometry(folder / "a.rawlog", folder / out).code, 0);
  }
  for (const char* name : {"transforms.json", "transforms_over_time.csv", "trajectory.tum"}) {
    const std::string one = test::readText(folder / "one" / name);
    EXPECT_FALSE(one.empty());
    EXPECT_EQ(one, test::readText(folder / "two" / name)) << name;
  }
  // The folder of a run with a transform does not keep it.
  const test::Outcome outcome =
      runOdometry(folder / "a.rawlog", folder / "two", "--set Rendezvous.in_run=false");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_FALSE(fs::exists(folder / "two" / "transforms.json"));
  EXPECT_FALSE(readJson(folder / "two" / "summary.json").contains("peers"));
  EXPECT_EQ(test::readText(folder / "one" / "trajectory.tum"),
            test::readText(folder / "two" / "trajectory.tum"));
}

TEST(PeerRun, NothingWhereThereIsNoOtherRobot) {
  const test::TempFolder folder;
  rawlog::RawlogWriter writer((folder / "a.rawlog").string());
  for (int i = 0; i < 100; ++i) {
    writer.write(*test::odometryAt(test::kStart + 50 * i * test::kMs, 0.05 * i));
  }
  writer.finish();
  ASSERT_EQ(runOdometry(folder / "a.rawlog", folder / "out").code, 0);
  EXPECT_FALSE(fs::exists(folder / "out" / "transforms.json"));
  const Json summary = readJson(folder / "out" / "summary.json");
  EXPECT_FALSE(summary.contains("peers"));
  EXPECT_FALSE(summary["counters"].contains("peer_ranges"));
}

}  // namespace
}  // namespace vir
