/// vir-slam rendezvous as it is called from a shell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "vir_test_data.h"
#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::Outcome;
using test::quoted;
using Json = nlohmann::json;

const std::string kIni = quoted(test::sourceDir() + "/ini/two_robots.ini");

Json readJson(const fs::path& path) { return Json::parse(std::ifstream(path)); }

TEST(RendezvousCli, SaysWhatIsMissing) {
  // ini/two_robots.ini names the sample; this one names nobody.
  const Outcome none =
      test::virSlam("rendezvous " + quoted(test::sourceDir() + "/ini/two_robots_tiers.ini"));
  EXPECT_EQ(none.code, 2);
  EXPECT_TRUE(test::contains(none.text, "two or more robots")) << none.text;
  const Outcome gone =
      test::virSlam("rendezvous " + kIni + " --rawlog A=/none.rawlog --rawlog B=/none.rawlog");
  EXPECT_EQ(gone.code, 2);
  EXPECT_TRUE(test::contains(gone.text, "no such rawlog")) << gone.text;
  const Outcome unnamed = test::virSlam("rendezvous " + kIni + " --rawlog a.rawlog");
  EXPECT_EQ(unnamed.code, 2);
  EXPECT_TRUE(test::contains(unnamed.text, "NAME=FILE")) << unnamed.text;
  const Outcome id = test::virSlam("rendezvous " + kIni + " --rawlog A:x=a.rawlog");
  EXPECT_EQ(id.code, 2);
  EXPECT_TRUE(test::contains(id.text, "whole number")) << id.text;
  // Robots that are estimated here take a calibration as `run` does.
  const test::TempFolder folder;
  const Outcome calibration =
      test::virSlam("rendezvous " + kIni + " --set Estimator.calibration=/no/such.yaml --out " +
                    quoted((folder / "o").string()));
  EXPECT_EQ(calibration.code, 2);
  EXPECT_TRUE(test::contains(calibration.text, "/no/such.yaml")) << calibration.text;
  EXPECT_FALSE(fs::exists(folder / "o"));
}

TEST(RendezvousCli, ListsThePluginAndItsSettings) {
  EXPECT_TRUE(test::contains(test::virSlam("plugins").text, "nlopt"));
  const Outcome settings = test::virSlam("plugins nlopt");
  EXPECT_EQ(settings.code, 0);
  EXPECT_TRUE(test::contains(settings.text, "false_alarm")) << settings.text;
}

/// The robots with cameras that come with the program, as ini/two_robots.ini names them.
TEST(RendezvousCli, RunsTheSample) {
  const test::TempFolder folder;
  const fs::path out = folder / "out";
  const Outcome outcome = test::virSlam("rendezvous " + kIni + " --out " + quoted(out.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_EQ(readJson(out / "A/summary.json")["estimator"], "vir");
  const Json t = readJson(out / "transforms.json")["transforms"][0];
  EXPECT_EQ(t["status"], "unique") << t;
  EXPECT_EQ(t["joint"], false);
  const Json error = readJson(out / "summary.json")["merge_errors"][0];
  std::printf("merged %.3f m, offset off by %.3f m, yaw by %.2f deg, unique after %.1f s\n",
              error["merged_rmse_m"].get<double>(), error["offset_error_m"].get<double>(),
              error["yaw_error_deg"].get<double>(), t["first_unique_s"].get<double>());
  EXPECT_LT(error["merged_rmse_m"], 0.15) << error;
  EXPECT_LT(error["offset_error_m"], 0.12) << error;
  EXPECT_LT(error["yaw_error_deg"], 2) << error;
  for (const char* name : {"scene.3Dscene", "rendezvous.svg", "landmarks.ply", "A/used.ini"}) {
    EXPECT_GT(fs::file_size(out / name), 100u) << name;
  }
}

/// The real pair of ground robots.
class TwoRobots : public ::testing::Test {
 protected:
  void SetUp() override {
    VIR_REQUIRE_DATA(graph, "range_graphs/tiers_AB.pyfg");
    for (const std::string robot : {"A", "B"}) {
      const Outcome import =
          test::virSlam("import pyfg " + quoted(graph.string()) + " --set pyfg.robot=" + robot +
                        " --out " + quoted(rawlog(robot)));
      ASSERT_EQ(import.code, 0) << import.text;
    }
  }
  std::string rawlog(const std::string& robot) const {
    return (folder_ / (robot + ".rawlog")).string();
  }
  fs::path out() const { return folder_ / "out"; }
  Outcome meet(const std::string& more) const {
    return test::virSlam("rendezvous " + kIni + " --rawlog " + quoted("A=" + rawlog("A")) +
                         " --rawlog " + quoted("B=" + rawlog("B")) + " --out " +
                         quoted(out().string()) + " " + more);
  }

  test::TempFolder folder_;
};

TEST_F(TwoRobots, JointlyWithinCentimetres) {
  const Outcome outcome = meet("");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const Json t = readJson(out() / "transforms.json")["transforms"][0];
  EXPECT_EQ(t["from"], "B");
  EXPECT_EQ(t["to"], "A");
  EXPECT_EQ(t["status"], "unique");
  EXPECT_EQ(t["joint"], true);
  EXPECT_EQ(t["covariance"].size(), 4u);
  EXPECT_TRUE(t["alternative"].is_null());
  const Json error = readJson(out() / "summary.json")["merge_errors"][0];
  const double z = t["t_m"][2].get<double>();
  const auto level = [z](double error_m) { return std::sqrt(error_m * error_m - z * z); };
  EXPECT_LT(level(error["merged_rmse_m"].get<double>()), 0.03) << error;
  EXPECT_LT(level(error["offset_error_m"].get<double>()), 0.02) << error;
  const double height_sigma = std::sqrt(t["covariance"][3][3].get<double>());
  EXPECT_GT(height_sigma, 0.2) << "it is not known";
  // They drive on one floor: the middle of the two ends that fit alike.
  EXPECT_LT(std::abs(z), 0.3 * height_sigma);
  EXPECT_LT(error["yaw_error_deg"].get<double>(), 0.3) << error;
  for (const char* name :
       {"trajectory_A.tum", "trajectory_B.tum", "landmarks.ply", "rendezvous.svg",
        "transforms_over_time.csv", "used.ini", "run.log", "A/trajectory.tum", "B/summary.json"}) {
    EXPECT_TRUE(fs::exists(out() / name)) << name;
  }
}

TEST_F(TwoRobots, FromWhatComesOverTheAirAlone) {
  const Outcome outcome = meet("--set Rendezvous.joint=false --set Rendezvous.use_anchors=false");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const Json t = readJson(out() / "transforms.json")["transforms"][0];
  EXPECT_EQ(t["status"], "unique");
  EXPECT_EQ(t["joint"], false);
  EXPECT_LT(t["first_unique_s"].get<double>(), 25);
  const Json error = readJson(out() / "summary.json")["merge_errors"][0];
  EXPECT_LT(error["merged_rmse_m"], 0.12) << error;
  // A wrong answer on the way would be worse than a late one.
  std::ifstream history(out() / "transforms_over_time.csv");
  std::string line;
  std::getline(history, line);
  const double yaw = t["yaw_rad"], x = t["t_m"][0];
  int unique = 0;
  while (std::getline(history, line)) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    if (cells[3] != "unique") continue;
    ++unique;
    EXPECT_NEAR(std::remainder(std::stod(cells[8]) - yaw, 2 * M_PI), 0, 0.3) << line;
    EXPECT_NEAR(std::stod(cells[9]), x, 1.0) << line;
  }
  EXPECT_GT(unique, 100);
}

}  // namespace
}  // namespace vir
