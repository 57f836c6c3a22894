/// Surveyed anchors, from a recording and a table to results in the survey's frame.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "vir/evaluation/trajectory.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir/simulation/flights.h"
#include "vir/simulation/simulate_odometry.h"
#include "vir/simulation/simulate_ranges.h"
#include "vir_test_paths.h"
#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"
#include "vir_test_whole_files.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;

constexpr TimeNs kOffset = 1'700'000'000'000'000'000;
const std::vector<Vec3> kAnchors{{9, 7, 2.5}, {-8, 6, 1.2}, {-7, -8, 3.0}, {8, -7, 0.6}};
const std::vector<double> kIds{0x84, 7, 1000000, 12};
/// What a survey in the frame of the ground truth says.
constexpr const char* kTable =
    "name,x [mm],y [mm],z [mm],sigma [mm]\n"
    "0x84,9000,7000,2500,20\n"
    "7,-8000,6000,1200,20\n"
    "north-wall,-7000,-8000,3000,20\n"
    "C,8000,-7000,600,20\n";

std::shared_ptr<mrpt::obs::CObservationRobotPose> posed(TimeNs t, const std::string& label,
                                                        const Pose& pose) {
  auto o = std::make_shared<mrpt::obs::CObservationRobotPose>();
  o->timestamp = rawlog::toMrptTime(kOffset + t);
  o->sensorLabel = label;
  o->pose.mean = rawlog::toMrptPose(pose);
  return o;
}

/// Odometry of a world of its own, ranges, and the truth in the survey's frame, there and in a file
/// beside it.
void write(const std::string& path, const std::string& truth_path) {
  simulation::FlightOptions flight;
  flight.length_m = 60;
  flight.start_m = {1, -2, 0.5};
  flight.start_heading_deg = 77;
  const simulation::Motion motion = simulation::flight("eight", flight);
  simulation::OdometrySimulationOptions drift;
  drift.scale_error = 0.02;
  drift.yaw_walk = 0.005;
  drift.position_walk = 0.01;
  simulation::RangeSimulationOptions o;
  for (const Vec3& a : kAnchors) o.anchor_m.insert(o.anchor_m.end(), a.data(), a.data() + 3);
  o.anchor_id = kIds;
  o.rate_hz = 8;
  const std::vector<simulation::SimulatedRange> ranges = simulation::simulateRanges(motion, o);
  rawlog::RawlogWriter writer(path);
  std::size_t next = 0;
  std::ofstream truth(truth_path);
  for (const StampedPose& p : simulation::simulateOdometry(motion, drift)) {
    for (; next < ranges.size() && ranges[next].t <= p.t; ++next) {
      auto range = test::rangeAt(kOffset + ranges[next].t, ranges[next].anchor);
      range->stdError = 0.05F;
      range->sensedData.back().sensedDistance = static_cast<float>(ranges[next].range_m);
      range->sensedData.back().sensorLocationOnRobot = mrpt::poses::CPoint3D(0, 0, 0);
      writer.write(*range);
    }
    writer.write(*posed(p.t, "ODOM", p.T_W_B));
    writer.write(*posed(p.t, "GT", motion.poseAt(p.t)));
    truth << evaluation::tumLine({kOffset + p.t, motion.poseAt(p.t)}) << "\n";
  }
  writer.finish();
}

class Survey : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TempFolder;
    write(at("flight.rawlog"), at("truth.tum"));
    // As an importer leaves it that met an anchor by name.
    test::writeText(at("flight.ini"),
                    "// Written by vir-slam import\n// anchor 1000000 is 'north-wall'\n");
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static std::string at(const std::string& name) { return (*folder_ / name).string(); }
  static test::Outcome run(const std::string& out, const std::string& more) {
    return test::virSlam("run " + quoted(test::sourceDir() + "/ini/odometry_range.ini") +
                         " --rawlog " + quoted(at("flight.rawlog")) + " --out " + quoted(at(out)) +
                         " " + more);
  }
  static nlohmann::json summaryOf(const std::string& out) {
    std::ifstream in(at(out) + "/summary.json");
    return nlohmann::json::parse(in, nullptr, false);
  }
  static test::TempFolder* folder_;
};
test::TempFolder* Survey::folder_ = nullptr;

TEST_F(Survey, ResultsComeOutInItsFrame) {
  test::writeText(at("anchors.csv"), kTable);
  const test::Outcome o = run("a", "--anchors " + quoted(at("anchors.csv")));
  ASSERT_EQ(o.code, 0) << o.text;
  const auto summary = summaryOf("a");
  EXPECT_EQ(summary["survey"]["status"], "found");
  EXPECT_TRUE(summary["survey"]["findings"].empty()) << summary["survey"];
  EXPECT_TRUE(summary["survey"]["open"].empty());
  EXPECT_EQ(summary["survey"]["covariance"].size(), 16u);
  for (const auto& a : summary["survey"]["anchors"]) {
    EXPECT_TRUE(a["used"]);
    EXPECT_LT(a["off"], 0.15);
  }
  // No alignment: the frames are the same.
  for (const char* name : {"trajectory_survey.tum", "trajectory_smoothed_survey.tum"}) {
    const std::string json = at(std::string(name) + ".json");
    const test::Outcome e =
        test::virSlam("evaluate --align none --reference " + quoted(at("truth.tum")) + " " +
                      quoted(at("a/") + name) + " --json " + quoted(json));
    ASSERT_EQ(e.code, 0) << e.text;
    std::ifstream in(json);
    const auto result = nlohmann::json::parse(in, nullptr, false);
    EXPECT_LT(result["estimates"][0]["ate_position_m"]["rmse"], 0.25) << result.dump();
  }
  const std::string table = test::readText(at("a/anchors_survey.csv"));
  EXPECT_EQ(table.substr(0, 9), "id,x,y,z,");
  EXPECT_TRUE(contains(table, "\n1000000,")) << table;
  // What was used says all of it.
  const test::Outcome again =
      test::virSlam("run " + quoted(at("a/used.ini")) + " --out " + quoted(at("again")));
  ASSERT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(test::readText(at("again/trajectory_survey.tum")),
            test::readText(at("a/trajectory_survey.tum")));
}

TEST_F(Survey, APathInAnIniIsRelativeToIt) {
  test::writeText(at("hall.csv"), kTable);
  std::string ini = test::readText(test::sourceDir() + "/ini/odometry_range.ini");
  ini += "\n[Ranges]\nsurveyed_anchors = hall.csv\n";
  test::writeText(at("hall.ini"), ini);
  const test::Outcome o = test::virSlam("run " + quoted(at("hall.ini")) + " --rawlog " +
                                        quoted(at("flight.rawlog")) + " --out " + quoted(at("h")));
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(summaryOf("h")["survey"]["status"], "found");
  EXPECT_TRUE(contains(o.text, "found, 4 of 4 hold")) << o.text;
}

TEST_F(Survey, WhatIsWrongWithItIsSaid) {
  test::writeText(at("off.csv"),
                  "id,x,y,z,sigma\n0x84,9,7,2.5,0.02\n7,-6.4,4.8,1.2,0.02\n1000000,-7,-8,3,0.02\n"
                  "12,8,-7,0.6,0.02\n");
  test::Outcome o = run("off", "--anchors " + quoted(at("off.csv")));
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(contains(o.text, "survey: anchor 7 is ")) << o.text;
  EXPECT_TRUE(contains(o.text, "where the survey has it")) << o.text;
  const auto survey = summaryOf("off")["survey"];
  EXPECT_EQ(survey["status"], "found");
  ASSERT_EQ(survey["anchors"].size(), 4u);
  for (const auto& a : survey["anchors"]) EXPECT_EQ(a["used"], a["id"] != 7) << a;
  EXPECT_NEAR(survey["anchors"][1]["off"], 2.0, 0.2) << "it is found where it truly is";
  test::writeText(at("others.csv"), "id,x,y,z\n84,9,7,2.5\n70,-8,6,1.2\n");
  o = run("others", "--anchors " + quoted(at("others.csv")));
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(contains(o.text, "none of its ids (84, 70) is among those heard")) << o.text;
  EXPECT_TRUE(contains(o.text, "write 0x84")) << o.text;
  EXPECT_FALSE(std::filesystem::exists(at("others/trajectory_survey.tum")));
}

TEST_F(Survey, ATableThatCannotBeReadKeepsTheRunFromStarting) {
  test::writeText(at("bad.csv"), "id,x,y,z\n7,1,2\n");
  test::Outcome o = run("bad", "--anchors " + quoted(at("bad.csv")));
  EXPECT_EQ(o.code, 2);
  EXPECT_TRUE(contains(o.text, "bad.csv:2")) << o.text;
  EXPECT_FALSE(std::filesystem::exists(at("bad")));
  o = run("bad", "--anchors " + quoted(at("missing.csv")));
  EXPECT_EQ(o.code, 2);
  EXPECT_TRUE(contains(o.text, "missing.csv")) << o.text;
}

}  // namespace
}  // namespace vir
