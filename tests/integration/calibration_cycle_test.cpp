/// A calibration that is found, taken in again, and found from several recordings; with the program
/// as a user calls it.
#include <gtest/gtest.h>

#include <cmath>

#include "end_to_end.h"
#include "vir/formats/calibration_file.h"
#include "vir/results/calibration_yaml.h"
#include "vir/types/calibration_change.h"

namespace vir {
namespace {

using test::contains;
using test::Outcome;
using test::quoted;
using test::virSlam;

constexpr double kDeg = M_PI / 180;

/// The rig of every recording here: what [Camera] of the simulator is by default, its clock 8 ms
/// off.
Calibration truth() {
  Calibration c;
  c.camera = {752, 480, 458.654, 457.296, 367.215, 248.375, Distortion::radtan};
  c.camera.dist = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  Mat3 forward;
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  c.T_B_C = {Quat(forward), Vec3(0.05, 0.02, -0.01)};
  c.time_offset_s = 0.008;
  return c;
}

/// As people have it.
Calibration wrong() {
  Calibration c = truth();
  c.camera.fx *= 1.01;
  c.camera.fy *= 1.01;
  c.camera.cx += 3;
  c.camera.cy -= 3;
  c.T_B_C.q = c.T_B_C.q * expQuat(kDeg * Vec3(0.6, -0.6, 0.5));
  c.T_B_C.p += Vec3(0.006, -0.006, 0.005);
  c.time_offset_s = 0;
  c.gyro_gain = Vec3::Constant(0.003);
  return c;
}

class CalibrationCycle : public testing::Test {
 protected:
  /// Tracks of a flight, camera and IMU as truth() says but for noise and biases.
  std::string simulated(int seed, double length_m = 36) {
    const std::string name = path("s" + std::to_string(seed) + ".rawlog");
    const Outcome made = virSlam(
        "simulate " + quoted(test::sourceDir() + "/ini/simulate_benchmark.ini") + " --out " +
        quoted(name) + " --set simulator.seed=" + std::to_string(seed) +
        " --set Flight.length_m=" + std::to_string(length_m) +
        " --set Flight.sway_deg=5 --set simulator.ranges=false --set Camera.time_offset_s=0.008"
        " --set Camera.focal_error=0 --set Camera.center_error_px=0 --set Camera.mount_error_deg=0"
        " --set SimulatedImu.scale_error=0 --set SimulatedImu.misalignment_rad=0");
    EXPECT_EQ(made.code, 0) << made.text;
    return name;
  }
  std::string written(const std::string& name, const Calibration& c) {
    test::writeText(folder_ / name, results::calibrationYaml(c, CalibrationSigma()));
    return path(name);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string read(const std::string& name) const { return test::readText(folder_ / name); }

  test::TempFolder folder_;
};

Calibration calibrationIn(const std::string& yaml) {
  const auto file = formats::readCalibrationFile(yaml);
  const formats::CalibratedCamera& c = file.cameras.at(0);
  const formats::ImuCorrection k = file.imu_correction.value();
  return {
      c.camera,        c.T_B_C.value(), c.time_offset_s.value(), c.readout_s.value(), k.gyro_gain,
      k.gyro_axes_rad, k.acc_gain};
}

CalibrationSigma sigmaIn(const std::string& yaml) {
  const auto file = formats::readCalibrationFile(yaml);
  const formats::CameraSigma s = file.cameras.at(0).sigma;
  const formats::ImuCorrection k = file.imu_correction.value();
  return {s.position_m.value(),          s.rotation_rad.value(),  s.time_offset_s.value(),
          s.readout_s.value(),           s.focal.value(),         s.aspect.value(),
          s.centre_px.value(),           s.distortion.value(),    k.gyro_gain_sigma.value(),
          k.gyro_axes_sigma_rad.value(), k.acc_gain_sigma.value()};
}

TEST_F(CalibrationCycle, TheNextRunTakesInWhatTheFirstFound) {
  const std::string rawlog = simulated(1);
  const test::RunResult first =
      test::runVir(rawlog, path("a"), "--calibration " + quoted(written("w.yaml", wrong())));
  ASSERT_EQ(first.outcome.code, 0) << first.outcome.text;
  EXPECT_TRUE(contains(first.outcome.text, "gains and axes of the IMU")) << first.outcome.text;
  EXPECT_TRUE(contains(read("a/used.ini"), "gyro_gain = 0.003 0.003 0.003\n"));
  EXPECT_TRUE(contains(read("a/report.html"), "Calibration over time"));

  const std::string found = path("a/calibration.yaml");
  const test::RunResult second = test::runVir(rawlog, path("b"), "--calibration " + quoted(found));
  ASSERT_EQ(second.outcome.code, 0) << second.outcome.text;
  const std::string used = read("b/used.ini");
  EXPECT_TRUE(contains(used, "calibration = " + found + "\n")) << used;
  EXPECT_FALSE(contains(used, "gyro_gain = 0 0 0\n")) << "the gains are values to begin with";
  EXPECT_FALSE(contains(used, "focal_sigma = 0.01\n")) << "and how sure they are a prior";
  EXPECT_LT(sigmaIn(path("b/calibration.yaml")).focal, sigmaIn(found).focal);
  EXPECT_LT(second.summary["ate_posyaw_m"], 1.3 * first.summary["ate_posyaw_m"].get<double>());

  // What was used tells all: the same again, byte by byte.
  const Outcome again =
      virSlam("run " + quoted(path("b/used.ini")) + " --out " + quoted(path("c")));
  ASSERT_EQ(again.code, 0) << again.text;
  for (const char* file : {"trajectory.tum", "calibration.yaml", "used.ini"}) {
    EXPECT_EQ(read("b/" + std::string(file)), read("c/" + std::string(file))) << file;
  }
  // --set goes before the file, and stays so when the used settings run again.
  const std::string set = " --set Imu.acc_gain='0.001 0 0' --set Estimator.calibrate=trust";
  const test::RunResult trust =
      test::runVir(rawlog, path("d"), "--calibration " + quoted(found) + set);
  ASSERT_EQ(trust.outcome.code, 0) << trust.outcome.text;
  EXPECT_TRUE(contains(read("d/used.ini"), "acc_gain = 0.001 0 0\n"));
  EXPECT_FALSE(std::filesystem::exists(path("d/calibration.yaml")));
  EXPECT_FALSE(contains(read("d/report.html"), "Calibration over time"));
  ASSERT_EQ(virSlam("run " + quoted(path("d/used.ini")) + " --out " + quoted(path("e"))).code, 0);
  EXPECT_EQ(read("d/trajectory.tum"), read("e/trajectory.tum"));
}

TEST_F(CalibrationCycle, AFileThatIsNoneIsWrongUse) {
  const std::string rawlog = simulated(1, 6);
  const std::string whole = results::calibrationYaml(wrong(), CalibrationSigma());
  std::string broken = whole;
  broken.replace(broken.find("acc_gain_sigma: 0.005"), 21, "acc_gain_sigma: -1");
  test::writeText(folder_ / "broken.yaml", broken);
  test::writeText(folder_ / "named.ini", "[Estimator]\ncalibration = broken.yaml\n");
  const std::string rest = " --rawlog " + quoted(rawlog) + " --out " + quoted(path("out"));
  const std::string ini = quoted(test::sourceDir() + "/ini/euroc.ini");
  for (const std::string& arguments :
       {"run " + ini + rest + " --calibration " + quoted(path("broken.yaml")),
        "run " + quoted(path("named.ini")) + rest,
        "calibrate camera " + quoted(rawlog) + " --calibration " + quoted(path("broken.yaml"))}) {
    const Outcome outcome = virSlam(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.text;
    EXPECT_TRUE(contains(outcome.text, "broken.yaml: `inertial.acc_gain_sigma` is -1"))
        << outcome.text;
    EXPECT_FALSE(std::filesystem::exists(path("out")));
  }
  test::writeText(folder_ / "out/calibration.yaml", whole);
  test::writeText(folder_ / "out/summary.json",
                  "{\"verdict\": \"good\"}");  // a former run's folder
  const Outcome own =
      virSlam("run " + ini + rest + " --calibration " + quoted(path("out/calibration.yaml")));
  EXPECT_EQ(own.code, 2) << own.text;
  EXPECT_TRUE(contains(own.text, "would be written over by this run")) << own.text;
  EXPECT_EQ(read("out/calibration.yaml"), whole);
}

TEST_F(CalibrationCycle, ThreeRecordingsFindTheCalibration) {
  std::string recordings;
  for (const int seed : {1, 2, 3}) recordings += quoted(simulated(seed)) + " ";
  Calibration given = wrong();
  given.camera.dist[0] += 0.01;
  const Outcome outcome =
      virSlam("calibrate camera " + recordings + " --calibration " +
              quoted(written("w.yaml", given)) + " --passes 12 --out " + quoted(path("rig")));
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  for (const char* part : {"given", "found", "sigma", "time offset [ms]", "gyro gain x [%]",
                           "readout [ms]", "Written to"}) {
    EXPECT_TRUE(contains(outcome.text, part)) << part << "\n" << outcome.text;
  }
  const std::string yaml = path("rig/calibration.yaml");
  const Calibration found = calibrationIn(yaml);
  const CalibrationChange sigma = covarianceOf(sigmaIn(yaml)).diagonal().cwiseSqrt();
  const CalibrationChange off = changeBetween(truth(), found);
  const CalibrationChange before = changeBetween(truth(), given);
  for (int i = 0; i < kCalibrationSize; ++i) {
    EXPECT_LT(std::abs(off[i]), 3 * sigma[i]) << "number " << i << "\n" << outcome.text;
  }
  // Nearer than given: rotation, clock, focal length, centre, lens, gyro.
  for (const auto& [from, count] :
       {std::pair(0, 3), {3, 3}, {6, 1}, {8, 1}, {10, 2}, {12, 1}, {14, 3}}) {
    EXPECT_LT(off.segment(from, count).norm(), before.segment(from, count).norm())
        << "numbers from " << from << "\n"
        << outcome.text;
  }
  EXPECT_LT(std::abs(off[6]), 0.0005) << outcome.text;
  EXPECT_LT(std::abs(off[8]), 0.004) << outcome.text;
}

TEST_F(CalibrationCycle, WhatCalibrateCameraCannotUse) {
  const std::string rawlog = simulated(1, 6);
  EXPECT_EQ(virSlam("calibrate camera").code, 2);
  EXPECT_EQ(virSlam("calibrate camera /nowhere.rawlog").code, 2);
  EXPECT_EQ(virSlam("calibrate camera " + quoted(rawlog) + " --passes 1").code, 2);
  EXPECT_EQ(virSlam("calibrate camera " + quoted(rawlog) + " --set Window.frist=1").code, 2);
  const std::string out = " --out " + quoted(path("c.yaml"));
  const Outcome none =
      virSlam("calibrate camera " + quoted(rawlog) + out + " --set Estimator.start_offset_s=1000");
  EXPECT_EQ(none.code, 1) << none.text;
  EXPECT_TRUE(contains(none.text, "no recording says anything")) << none.text;
  EXPECT_FALSE(std::filesystem::exists(path("c.yaml")));
}

}  // namespace
}  // namespace vir
