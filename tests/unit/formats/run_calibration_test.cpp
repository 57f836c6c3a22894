/// The calibration.yaml of a run: values, standard deviations, and the settings they become.
#include <gtest/gtest.h>

#include <algorithm>

#include "vir/formats/calibration_file.h"
#include "vir_test_temp_folder.h"

namespace vir::formats {
namespace {

const std::string kCamera =
    "cam0:\n  camera_model: pinhole\n  intrinsics: [400, 380, 320, 240]\n"
    "  distortion_model: none\n  resolution: [640, 480]\n"
    "  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
const std::string kSigmas =
    "  focal_and_centre_sigma: [0.8, 0.76, 0.5, 0.6]\n  aspect_sigma: 0.0004\n"
    "  distortion_sigma: 0.004\n"
    "  T_cam_imu_sigma: {position_m: 0.002, rotation_rad: 0.0005}\n"
    "  timeshift_cam_imu: -0.005\n  timeshift_cam_imu_sigma: 0.0001\n"
    "  readout_s: -0.0001\n  readout_sigma_s: 0.00009\n";
const std::string kInertial =
    "inertial:\n  gyro_gain: [0.01, -0.002, 0.003]\n  gyro_gain_sigma: 0.001\n"
    "  gyro_axes_rad: [0.001, 0.002, 0.004]\n  gyro_axes_sigma_rad: 0.0002\n"
    "  acc_gain: [0, 0.005, 0]\n  acc_gain_sigma: 0.003\n";

CalibrationFile read(const std::string& text) {
  const test::TempFolder folder;
  test::writeText(folder / "c.yaml", text);
  return readCalibrationFile((folder / "c.yaml").string());
}

std::string errorOf(const std::string& text) {
  try {
    read(text);
  } catch (const CalibrationError& e) {
    return e.what();
  }
  return "";
}

TEST(RunCalibration, IsReadWithItsStandardDeviations) {
  const CalibrationFile f = read(kCamera + kSigmas + kInertial);
  ASSERT_EQ(f.cameras.size(), 1u);
  const CalibratedCamera& c = f.cameras.front();
  EXPECT_DOUBLE_EQ(c.readout_s.value(), -0.0001);
  EXPECT_DOUBLE_EQ(c.sigma.focal.value(), 0.002);
  EXPECT_DOUBLE_EQ(c.sigma.centre_px.value(), 0.6);
  EXPECT_DOUBLE_EQ(c.sigma.distortion.value(), 0.004);
  EXPECT_DOUBLE_EQ(c.sigma.position_m.value(), 0.002);
  EXPECT_DOUBLE_EQ(c.sigma.rotation_rad.value(), 0.0005);
  ASSERT_TRUE(f.imu_correction);
  EXPECT_EQ(f.imu_correction->gyro_gain, Vec3(0.01, -0.002, 0.003));
  EXPECT_EQ(f.imu_correction->gyro_axes_rad, Vec3(0.001, 0.002, 0.004));
  EXPECT_EQ(f.imu_correction->acc_gain, Vec3(0, 0.005, 0));
  EXPECT_TRUE(f.notes.empty());
}

TEST(RunCalibration, BecomesSettings) {
  const std::vector<std::string> all = settingsOf(read(kCamera + kSigmas + kInertial));
  for (const char* line :
       {"Camera.time_offset_s=-0.005", "Window.readout_s=-1e-04", "Window.readout_sigma_s=9e-05",
        "Window.extrinsics_sigma_m=0.002", "Window.extrinsics_sigma_rad=5e-04",
        "Window.time_offset_sigma_s=1e-04", "Window.focal_sigma=0.002", "Window.aspect_sigma=4e-04",
        "Window.centre_sigma_px=0.6", "Window.distortion_sigma=0.004",
        "Imu.gyro_gain=0.01 -0.002 0.003", "Imu.gyro_axes_rad=0.001 0.002 0.004",
        "Imu.acc_gain=0 0.005 0", "Window.gyro_gain_sigma=0.001",
        "Window.gyro_axes_sigma_rad=2e-04", "Window.acc_gain_sigma=0.003"}) {
    EXPECT_EQ(std::count(all.begin(), all.end(), line), 1) << line;
  }
  EXPECT_EQ(all.size(), 16u);
  EXPECT_TRUE(settingsOf(read(kCamera)).empty()) << "a plain camchain sets no priors";
}

TEST(RunCalibration, WhatCannotBeIsRefusedByName) {
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string whole = kCamera + kSigmas + kInertial;
  ASSERT_EQ(errorOf(whole), "");
  struct Case {
    std::string from, to, named;
  };
  const std::vector<Case> cases = {
      {"gyro_gain: [0.01, -0.002, 0.003]", "gyro_gain: [0.01, -0.002]", "inertial.gyro_gain"},
      {"gyro_gain: [0.01, -0.002, 0.003]", "gyro_gain: [1.01, 1, 1]", "inertial.gyro_gain"},
      {"gyro_gain: [0.01, -0.002, 0.003]", "gyro_gain: [.nan, 0, 0]", "inertial.gyro_gain"},
      {"  acc_gain: [0, 0.005, 0]\n", "", "inertial.acc_gain"},
      {"acc_gain_sigma: 0.003", "acc_gain_sigma: 0", "inertial.acc_gain_sigma"},
      {"acc_gain_sigma: 0.003", "acc_gain_sigma: much", "inertial.acc_gain_sigma"},
      {kInertial, "inertial: 3\n", "inertial"},
      {"gyro_axes_sigma_rad: 0.0002", "gyro_axes_sigma_rad: -1", "inertial.gyro_axes_sigma_rad"},
      {"[0.8, 0.76, 0.5, 0.6]", "[0.8, 0.76, 0.5]", "cam0.focal_and_centre_sigma"},
      {"[0.8, 0.76, 0.5, 0.6]", "[0, 0.76, 0.5, 0.6]", "cam0.focal_and_centre_sigma"},
      {"position_m: 0.002", "position_m: -0.002", "cam0.T_cam_imu_sigma.position_m"},
      {"timeshift_cam_imu_sigma: 0.0001", "timeshift_cam_imu_sigma: 5",
       "cam0.timeshift_cam_imu_sigma"},
      {"readout_s: -0.0001", "readout_s: 33", "cam0.readout_s"},
      {"readout_sigma_s: 0.00009", "readout_sigma_s: .inf", "cam0.readout_sigma_s"}};
  for (const Case& c : cases) {
    const std::string error = errorOf(with(whole, c.from, c.to));
    EXPECT_NE(error.find(c.named), std::string::npos) << c.to << ": " << error;
  }
}

}  // namespace
}  // namespace vir::formats
