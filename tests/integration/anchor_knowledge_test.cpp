/// What is known of anchors beforehand, from a recording: an anchor the robot drops itself, and how
/// the ranges err with the distance.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "vir/ranging/range_bias_model.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir/simulation/flights.h"
#include "vir/simulation/simulate_odometry.h"
#include "vir/simulation/simulate_ranges.h"
#include "vir_test_paths.h"
#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::quoted;

constexpr TimeNs kOffset = 1'700'000'000'000'000'000;
const Vec3 kAnchor(9, 6, 2);

/// b_d(d): what the simulated radio adds to a distance.
double biasAt(double distance_m) { return 0.1 + 0.04 * distance_m; }

std::shared_ptr<mrpt::obs::CObservationRobotPose> posed(TimeNs t, const std::string& label,
                                                        const Pose& pose) {
  auto o = std::make_shared<mrpt::obs::CObservationRobotPose>();
  o->timestamp = rawlog::toMrptTime(kOffset + t);
  o->sensorLabel = label;
  o->pose.mean = rawlog::toMrptPose(pose);
  return o;
}

/// Odometry with ranges to anchor 3. `biased`: ranges err with the distance. `drop_s` > 0: then the
/// robot says that it has put the anchor down (which was there all the time).
void write(const std::string& path, bool biased, double drop_s) {
  simulation::FlightOptions flight_options;
  flight_options.length_m = 60;
  const simulation::Motion motion = simulation::flight("eight", flight_options);
  simulation::OdometrySimulationOptions drift;
  drift.scale_error = 0.02;
  drift.yaw_walk = 0.005;
  drift.position_walk = 0.01;
  simulation::RangeSimulationOptions o;
  o.anchor_m.assign(kAnchor.data(), kAnchor.data() + 3);
  o.anchor_id = {3};
  o.sigma_m = 0.05;
  const std::vector<simulation::SimulatedRange> ranges = simulation::simulateRanges(motion, o);
  rawlog::RawlogWriter writer(path);
  std::size_t next = 0;
  bool dropped = drop_s <= 0;
  for (const StampedPose& p : simulation::simulateOdometry(motion, drift)) {
    for (; next < ranges.size() && ranges[next].t <= p.t; ++next) {
      auto range = test::rangeAt(kOffset + ranges[next].t, 3);
      range->stdError = 0.05F;
      const double d = ranges[next].range_m;
      range->sensedData.back().sensedDistance = static_cast<float>(biased ? d + biasAt(d) : d);
      const double* lever = o.lever_arm_m.data();
      range->sensedData.back().sensorLocationOnRobot =
          mrpt::poses::CPoint3D(lever[0], lever[1], lever[2]);
      writer.write(*range);
    }
    const Pose truth = motion.poseAt(p.t);
    if (!dropped && p.t > motion.begin() + fromSeconds(drop_s)) {
      dropped = true;
      const auto event = posed(p.t, "ANCHOR:3", {Quat::Identity(), truth.inverse() * kAnchor});
      for (int i = 0; i < 3; ++i) event->pose.cov(i, i) = 0.01;
      writer.write(*event);
    }
    writer.write(*posed(p.t, "ODOM", p.T_W_B));
    writer.write(*posed(p.t, "GT", truth));
  }
  writer.finish();
}

nlohmann::json run(const std::string& rawlog, const std::string& out, const std::string& more) {
  const test::Outcome outcome =
      test::virSlam("run " + quoted(test::sourceDir() + "/ini/odometry_range.ini") + " --rawlog " +
                    quoted(rawlog) + " --out " + quoted(out) + " " + more);
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  std::ifstream in(out + "/summary.json");
  return nlohmann::json::parse(in, nullptr, false);
}

TEST(AnchorKnowledge, ADeployedAnchorIsUsedFromThenOn) {
  const test::TempFolder folder;
  const std::string with = (folder / "with.rawlog").string(),
                    without = (folder / "without.rawlog").string();
  write(with, false, 1.5);
  write(without, false, 0);
  const auto a = run(with, (folder / "a").string(), "");
  const auto b = run(without, (folder / "b").string(), "");
  ASSERT_EQ(a["anchors"].size(), 1u);
  EXPECT_EQ(a["anchors"][0]["id"], 3);
  EXPECT_EQ(a["anchors"][0]["state"], "estimated");
  // Every range that was only collected is one that could not help yet.
  const long early = a["counters"]["ranges_collected"], late = b["counters"]["ranges_collected"];
  EXPECT_LT(2 * early, late);
  EXPECT_LT(a["ate_posyaw_m"], 0.3);
}

TEST(AnchorKnowledge, ABiasModelTakesTheBiasOut) {
  const test::TempFolder folder;
  const std::string rawlog = (folder / "a.rawlog").string(), model = (folder / "bias.csv").string();
  write(rawlog, true, 0);
  std::vector<ranging::RangeBiasModel::Node> nodes;
  for (int d = 0; d <= 30; ++d) nodes.push_back({static_cast<double>(d), biasAt(d), 0.01});
  std::ofstream(model) << ranging::RangeBiasModel(nodes).text();
  const auto raw = run(rawlog, (folder / "raw").string(), "");
  const auto corrected =
      run(rawlog, (folder / "corrected").string(), "--set " + quoted("Ranges.bias_model=" + model));
  EXPECT_LT(corrected["ate_posyaw_m"], 0.25);
  EXPECT_LT(corrected["ate_posyaw_m"], 0.7 * raw["ate_posyaw_m"].get<double>());
}

TEST(AnchorKnowledge, ABiasModelThatIsMissingKeepsAnyEstimatorFromStarting) {
  const test::TempFolder folder;
  const std::string rawlog = (folder / "a.rawlog").string(),
                    sample = test::sourceDir() + "/rawlog/two_A.rawlog";
  write(rawlog, false, 0);
  const std::pair<std::string, std::string> runs[] = {{"odometry_range.ini", rawlog},
                                                      {"euroc.ini", sample}};
  for (const auto& [ini, recording] : runs) {
    const test::Outcome missing = test::virSlam(
        "run " + quoted(test::sourceDir() + "/ini/" + ini) + " --rawlog " + quoted(recording) +
        " --out " + quoted((folder / "x").string()) + " --set Ranges.bias_model=/no/such/file.csv");
    EXPECT_EQ(missing.code, 2) << ini;
    EXPECT_FALSE(std::filesystem::exists(folder / "x")) << ini << ": nothing has been run";
    for (const char* said : {"[Ranges] bias_model = /no/such/file.csv", "calibrate uwb"}) {
      EXPECT_TRUE(test::contains(missing.text, said)) << ini << ": " << missing.text;
    }
  }
}

}  // namespace
}  // namespace vir
