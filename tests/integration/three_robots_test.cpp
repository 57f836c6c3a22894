/// Three robots with cameras (as feature tracks) through the program: simulated, estimated, tied
/// together; and each one alone with what the others broadcast.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <memory>

#include "robot_truth.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::quoted;
using test::readJson;

constexpr const char* kWorld = R"([simulator]
robots = A B C
tracks = true

[Robot_A]
flight = eight
duration_s = 24

[Robot_B]
flight = letter_s
duration_s = 24
start_m = 2 -3 0.4
start_heading_deg = 115

[Robot_C]
flight = helix
duration_s = 24
start_m = -3 2 0.2
start_heading_deg = -40

[Flight]
length_m = 40
speed_mps = 1.4
rest_s = 2
height_m = 0.6

[SimulatedRanges]
anchor_m = 2.5 3.5 2.2
anchor_id = 1
lever_arm_m = 0.03 0 0.08
rate_hz = 10
sigma_m = 0.05
correlated_sigma_m = 0.03
nlos_share = 0.03

[SimulatedTeam]
peer_rate_hz = 10

[SimulatedOdometry]
scale_error = 0.004
scale_wander = 0.004
yaw_walk = 0.001
position_walk = 0.003
)";

const std::string kIni = quoted(test::sourceDir() + "/ini/two_robots.ini");

/// Simulated once for all cases.
class ThreeRobots : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TempFolder>();
    std::ofstream(*folder_ / "world.ini") << kWorld;
    const test::Outcome made =
        test::virSlam("simulate " + quoted((*folder_ / "world.ini").string()) + " --out " +
                      quoted((*folder_ / "three.rawlog").string()));
    ASSERT_EQ(made.code, 0) << made.text;
    std::string recordings;
    for (const char* robot : {"A", "B", "C"}) {
      recordings += " --rawlog " + quoted(std::string(robot) + "=" + rawlog(robot));
    }
    outcome_ = test::virSlam("rendezvous " + kIni + recordings + " --out " + quoted(out("met")));
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string rawlog(const std::string& robot) {
    return (*folder_ / ("three_" + robot + ".rawlog")).string();
  }
  static std::string out(const std::string& name) { return (*folder_ / name).string(); }
  static Trajectory path(const std::string& file) {
    std::ifstream in(file);
    evaluation::ReadReport report;
    return evaluation::readTum(in, &report);
  }

  static std::unique_ptr<test::TempFolder> folder_;
  static test::Outcome outcome_;
};

std::unique_ptr<test::TempFolder> ThreeRobots::folder_;
test::Outcome ThreeRobots::outcome_;

TEST_F(ThreeRobots, AreTiedTogetherAndTheirLoopCloses) {
  ASSERT_EQ(outcome_.code, 0) << outcome_.text;
  const Json all = readJson(out("met/transforms.json"));
  EXPECT_EQ(all["common_frame"], "A");
  ASSERT_EQ(all["transforms"].size(), 3u);
  std::map<std::string, Pose> world;
  for (const char* robot : {"A", "B", "C"}) {
    world[robot] =
        test::worldOf(test::truthIn(rawlog(robot)), path(out("met/") + robot + "/trajectory.tum"));
  }
  for (const Json& t : all["transforms"]) {
    ASSERT_EQ(t["status"], "unique") << t;
    const std::string from = t["from"], to = t["to"];
    const Pose wanted = world[to].inverse() * world[from];
    const test::Deviation d = test::deviation(t, wanted);
    std::printf("%s in %s: offset off by %.3f m, yaw by %.2f deg, unique after %.1f s\n",
                from.c_str(), to.c_str(), d.offset_m, d.yaw_deg, t["first_unique_s"].get<double>());
    EXPECT_LT(d.offset_m, 0.3) << t;
    EXPECT_LT(d.yaw_deg, 3) << t;
  }
  ASSERT_EQ(all["loops"].size(), 1u);
  EXPECT_EQ(all["loops"][0]["robots"], "A B C");
  EXPECT_EQ(all["loops"][0]["consistent"], true) << all["loops"];
  for (const Json& e : readJson(out("met/summary.json"))["merge_errors"]) {
    EXPECT_LT(e["merged_rmse_m"], 0.3) << e;
  }
  EXPECT_GT(fs::file_size(out("met/scene.3Dscene")), 1000u);
}

TEST_F(ThreeRobots, FinishedRunsNeedNoEstimating) {
  ASSERT_EQ(outcome_.code, 0) << outcome_.text;
  std::string finished;
  for (const char* robot : {"A", "B", "C"}) {
    finished += " --rawlog " + quoted(std::string(robot) + "=" + out("met/") + robot);
  }
  const test::Outcome again = test::virSlam("rendezvous " + kIni + finished + " --out " +
                                            quoted(out("again")) + " --verbose");
  ASSERT_EQ(again.code, 0) << again.text;
  EXPECT_FALSE(fs::exists(out("again/A"))) << "nothing was estimated";
  const Json before = readJson(out("met/transforms.json"))["transforms"];
  const Json after = readJson(out("again/transforms.json"))["transforms"];
  ASSERT_EQ(after.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(after[i]["status"], "unique");
    EXPECT_EQ(after[i]["from"], before[i]["from"]);
    EXPECT_NEAR(after[i]["yaw_rad"], before[i]["yaw_rad"], 0.02);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(after[i]["t_m"][k].get<double>(), before[i]["t_m"][k].get<double>(), 0.1);
    }
  }
}

TEST_F(ThreeRobots, SaysWhatAFinishedRunLacks) {
  ASSERT_EQ(outcome_.code, 0) << outcome_.text;
  const std::string b = " --rawlog " + quoted("B=" + out("met/B"));
  fs::create_directories(out("empty"));
  const auto meet = [&](const std::string& a, const std::string& more) {
    return test::virSlam("rendezvous " + kIni + " --rawlog " + quoted("A=" + a) + b + " --out " +
                         quoted(out("refused")) + " " + more);
  };
  const test::Outcome empty = meet(out("empty"), "");
  EXPECT_EQ(empty.code, 2);
  EXPECT_TRUE(test::contains(empty.text, "no results folder")) << empty.text;
  EXPECT_TRUE(test::contains(empty.text, "trajectory.tum")) << empty.text;
  // The recording has gone since.
  fs::copy(out("met/A"), out("moved"));
  Json summary = readJson(out("moved/summary.json"));
  summary["rawlog"] = "gone_for_good.rawlog";
  std::ofstream(out("moved/summary.json")) << summary;
  const test::Outcome gone = meet(out("moved"), "");
  EXPECT_EQ(gone.code, 2);
  EXPECT_TRUE(test::contains(gone.text, "gone_for_good.rawlog")) << gone.text;
  EXPECT_TRUE(test::contains(gone.text, "--ranges A=FILE")) << gone.text;
  const test::Outcome given = meet(out("moved"), "--ranges " + quoted("A=" + rawlog("A")));
  EXPECT_EQ(given.code, 0) << given.text;
  EXPECT_EQ(meet(rawlog("A"), "--ranges " + quoted("A=" + rawlog("A"))).code, 2);
  EXPECT_EQ(meet(out("moved"), "--ranges " + quoted("X=" + rawlog("A"))).code, 2);
}

TEST_F(ThreeRobots, OneAloneFindsTheOthersFromWhatTheyBroadcast) {
  ASSERT_EQ(outcome_.code, 0) << outcome_.text;
  const test::RunResult run = test::runVir(rawlog("A"), out("alone"));
  ASSERT_EQ(run.outcome.code, 0) << run.outcome.text;
  const Json transforms = readJson(out("alone/transforms.json"))["transforms"];
  ASSERT_EQ(transforms.size(), 2u);
  const Pose T_G_own = test::worldOf(test::truthIn(rawlog("A")), run.trajectory);
  for (std::size_t i = 0; i < 2; ++i) {
    const Json& t = transforms[i];
    EXPECT_EQ(t["from"], std::to_string(i + 1));
    ASSERT_EQ(t["status"], "unique") << t;
    EXPECT_EQ(t["anchors_used"], 1) << "PEER:<id>:ANCHOR:1 was heard";
    const Pose told = test::toldWorld(rawlog(i == 0 ? "B" : "C"));
    const test::Deviation d = test::deviation(t, T_G_own.inverse() * told);
    std::printf("robot %zu: offset off by %.3f m, yaw by %.2f deg\n", i + 1, d.offset_m, d.yaw_deg);
    EXPECT_LT(d.offset_m, 0.3) << t;
    EXPECT_LT(d.yaw_deg, 3) << t;
  }
  EXPECT_EQ(run.summary["peers"].size(), 2u);
  EXPECT_EQ(run.counter("peer_ranges_without_broadcast"), 0);
}

}  // namespace
}  // namespace vir
