/// What a run writes of its calibration is what the next one takes in.
#include "vir/results/calibration_yaml.h"

#include <gtest/gtest.h>

#include "vir/core/settings.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/formats/calibration_file.h"
#include "vir/types/calibration_change.h"
#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

Calibration some(Distortion distortion) {
  Calibration c;
  c.camera = {752, 480, 458.654321, 457.296123, 367.215, 248.375};
  c.camera.distortion = distortion;
  const bool ratio = distortion == Distortion::double_sphere;
  c.camera.dist = {ratio ? -0.2 : -0.28340811, ratio ? 0.6 : 0.07395907};
  if (distortion == Distortion::omni) c.camera.dist = {0.9, -0.1, 0.02, 1e-4, -2e-4};
  if (distortion == Distortion::none) c.camera.dist = {};
  c.T_B_C = {expQuat(Vec3(0.3, -1.2, 0.7)), Vec3(0.0511, 0.0217, -0.0123)};
  c.time_offset_s = -0.005012345;
  c.readout_s = -2.5e-5;
  c.gyro_gain = Vec3(0.0101, -0.0023, 0.0034);
  c.gyro_axes_rad = Vec3(0.0011, 0.0022, -0.0045);
  c.acc_gain = Vec3(-0.0071, 0.0053, 0.0002);
  return c;
}

CalibrationSigma sigmas() {
  CalibrationSigma s;
  s.position_m = 0.0021;
  s.rotation_rad = 0.00053;
  s.time_offset_s = 1.07e-4;
  s.readout_s = 8.9e-5;
  s.focal = 0.00123;
  s.aspect = 0.00045;
  s.centre_px = 0.61;
  s.distortion = 0.0041;
  s.gyro_gain = 0.0012;
  s.gyro_axes_rad = 2.3e-4;
  s.acc_gain = 0.0031;
  return s;
}

/// As `run --calibration` takes it in: the camera, and settings of the estimator.
std::pair<Calibration, CalibrationSigma> takenIn(const std::string& yaml) {
  const test::TempFolder folder;
  test::writeText(folder / "calibration.yaml", yaml);
  const auto file = formats::readCalibrationFile((folder / "calibration.yaml").string());
  Settings settings;
  for (const std::string& line : formats::settingsOf(file)) settings.set(line);
  estimator::EstimatorConfig config;
  SettingsReader reader(settings);
  describe(reader, config);
  reader.finish();
  config.validate();
  estimator::VisualInertialEstimator estimator(config);
  estimator.setCamera(file.cameras.at(0).camera, file.cameras.at(0).T_B_C.value());
  EXPECT_EQ(changeBetween(estimator.givenCalibration(), estimator.calibration()).norm(), 0)
      << "the window begins there";
  return {estimator.givenCalibration(), config.window.calibration};
}

TEST(CalibrationYaml, AsTheNextRunTakesItItIsWrittenAgain) {
  for (const Distortion d : {Distortion::none, Distortion::radtan, Distortion::equidistant,
                             Distortion::double_sphere, Distortion::omni}) {
    const std::string yaml = calibrationYaml(some(d), sigmas());
    const auto [calibration, sigma] = takenIn(yaml);
    EXPECT_EQ(calibrationYaml(calibration, sigma), yaml);
    const CalibrationChange off = changeBetween(some(d), calibration);
    EXPECT_LT(off.cwiseQuotient(covarianceOf(sigmas()).diagonal().cwiseSqrt()).norm(), 1e-3);
  }
}

TEST(CalibrationYaml, IsKalibrsLayout) {
  const std::string yaml = calibrationYaml(some(Distortion::radtan), sigmas());
  for (const char* line :
       {"cam0:\n", "  camera_model: pinhole\n",
        "  intrinsics: [458.654321, 457.296123, 367.215000, 248.375000]\n",
        "  distortion_model: radtan\n", "  resolution: [752, 480]\n",
        "  timeshift_cam_imu: -0.005012345\n", "  timeshift_cam_imu_sigma: 0.000107\n",
        "  readout_s: -0.000025000\n", "inertial:\n", "  gyro_gain: [0.0101, -0.0023, 0.0034]\n"}) {
    EXPECT_NE(yaml.find(line), std::string::npos) << line << yaml;
  }
}

TEST(CalibrationYaml, ASmallSigmaIsNotZero) {
  CalibrationSigma s = sigmas();
  s.position_m = s.gyro_gain = s.acc_gain = 2e-6;
  s.time_offset_s = 1.5e-7;
  const auto [calibration, sigma] = takenIn(calibrationYaml(some(Distortion::radtan), s));
  EXPECT_NEAR(sigma.position_m, 2e-6, 1e-11);
  EXPECT_NEAR(sigma.gyro_gain, 2e-6, 1e-11);
  EXPECT_NEAR(sigma.time_offset_s, 1.5e-7, 1e-12);
}

TEST(CalibrationYaml, FurtherCamerasStandInItByTheirLabels) {
  Calibration c = some(Distortion::radtan);
  CameraMount second{c.camera, c.T_B_C, 0.0031, 0.004};
  second.camera.fx = 461.5;
  second.T_B_C.p.y() += 0.11;
  second.T_B_C.q = second.T_B_C.q * expQuat(Vec3(0.01, -0.02, 0.005));
  c.further = {second, second};
  CalibrationSigma second_sigma = sigmas();
  second_sigma.position_m = 0.00123;
  second_sigma.time_offset_s = 0.00045;
  const std::string yaml = calibrationYaml(c, sigmas(), {"CAM2", "LEFT"}, {second_sigma});
  EXPECT_NE(yaml.find("# LEFT is left out"), std::string::npos) << yaml;
  const test::TempFolder folder;
  test::writeText(folder / "calibration.yaml", yaml);
  const auto file = formats::readCalibrationFile((folder / "calibration.yaml").string());
  ASSERT_EQ(file.cameras.size(), 2u);
  EXPECT_EQ(file.camera("cam1"), nullptr);
  const formats::CalibratedCamera* read = file.camera("cam2");
  ASSERT_NE(read, nullptr);
  EXPECT_NEAR(read->camera.fx, 461.5, 1e-6);
  ASSERT_TRUE(read->T_B_C);
  EXPECT_LT((read->T_B_C->p - second.T_B_C.p).norm(), 1e-9);
  EXPECT_LT(logQuat(read->T_B_C->q.conjugate() * second.T_B_C.q).norm(), 1e-9);
  EXPECT_NEAR(read->sigma.position_m.value(), 0.00123, 1e-9);
  EXPECT_NEAR(read->sigma.time_offset_s.value(), 0.00045, 1e-9);
  EXPECT_NEAR(read->time_offset_s.value(), 0.0031, 1e-9);
  EXPECT_NEAR(read->readout_s.value(), 0.004, 1e-9);
  EXPECT_NEAR(file.cameras[0].time_offset_s.value(), c.time_offset_s, 1e-9);
}

}  // namespace
}  // namespace vir::results
