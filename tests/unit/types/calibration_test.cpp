#include <gtest/gtest.h>

#include "vir/types/calibration_change.h"

namespace vir {
namespace {

Calibration some() {
  Calibration c;
  c.camera = {752, 480, 458.6, 457.3, 367.2, 248.4};
  c.T_B_C = {expQuat(Vec3(0.3, -1.2, 0.7)), Vec3(0.05, 0.02, -0.01)};
  c.time_offset_s = 0.004;
  c.gyro_gain = Vec3(0.001, 0.002, -0.003);
  return c;
}

TEST(Calibration, AChangeLeadsThereAndIsFoundAgain) {
  CalibrationChange by;
  for (int i = 0; i < kCalibrationSize; ++i) by[i] = 1e-3 * (i + 1) * (i % 2 == 0 ? 1 : -1);
  const Calibration to = changed(some(), by);
  EXPECT_LT((changeBetween(some(), to) - by).norm(), 1e-12);
  EXPECT_NEAR(to.time_offset_s, 0.004 + by[6], 1e-15);
  EXPECT_NEAR(to.camera.fx, 458.6 * (1 + by[8] + by[9]), 1e-9);
  EXPECT_NEAR(to.camera.fy, 457.3 * (1 + by[8] - by[9]), 1e-9);
  EXPECT_DOUBLE_EQ(to.camera.dist[0], by[12]);
  EXPECT_DOUBLE_EQ(to.camera.dist[1], by[13]);
  EXPECT_EQ(to.camera.distortion, Distortion::radtan) << "none with a coefficient";
  EXPECT_EQ(to.camera.width, 752);
  EXPECT_EQ(changeBetween(some(), some()).norm(), 0);
}

TEST(Calibration, TheRadialCoefficientsAreThoseOfTheModel) {
  CameraCalibration c = some().camera;
  c.distortion = Distortion::omni;
  c.dist = {0.9, -0.1, 0.02, 1e-4, -2e-4};
  const CameraCalibration by = withRadialChange(c, Vec2(0.01, 0.002));
  EXPECT_EQ(by.dist[0], 0.9) << "the sphere's";
  EXPECT_DOUBLE_EQ(by.dist[1], -0.09);
  EXPECT_DOUBLE_EQ(by.dist[2], 0.022);
  EXPECT_EQ(by.distortion, Distortion::omni);
}

TEST(Calibration, SigmasAreOfTheWorstAxis) {
  CalibrationSigma sigma;
  sigma.focal = 0.02;
  sigma.readout_s = 3e-4;
  CalibrationChange s = covarianceOf(sigma).diagonal().cwiseSqrt();
  s[1] = 0.5;
  s[11] = 7;
  const CalibrationSigma back = sigmaOf(s);
  EXPECT_DOUBLE_EQ(back.position_m, 0.5);
  EXPECT_DOUBLE_EQ(back.centre_px, 7);
  EXPECT_DOUBLE_EQ(back.focal, 0.02);
  EXPECT_DOUBLE_EQ(back.readout_s, 3e-4);
  EXPECT_DOUBLE_EQ(back.acc_gain, sigma.acc_gain);
}

}  // namespace
}  // namespace vir
