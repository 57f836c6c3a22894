#include "vir/ranging/range_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "vir_test_noise.h"

namespace {

using vir::ranging::CalibrationSample;

double bias(double d) { return 0.08 + 0.06 * std::exp(-d) - 0.01 * d; }

/// A sweep back and forth between 0.5 and 8.5 m.
std::vector<CalibrationSample> sweep(int n, double nlos, double rho, int seed) {
  vir::test::Noise noise(seed);
  std::vector<CalibrationSample> out;
  double x = noise.normal();
  for (int i = 0; i < n; ++i) {
    x = rho * x + std::sqrt(1 - rho * rho) * noise.normal();
    const double d = 4.5 + 4 * std::sin(0.011 * i);
    double r = bias(d) + 0.04 * x;
    if (noise.uniform() < nlos) r += 0.3 + 1.5 * noise.uniform();
    out.push_back({i * 50'000'000LL, 0, d, r});
  }
  return out;
}

TEST(RangeCalibration, FindsTheBias) {
  const auto c = vir::ranging::calibrateRangeBias(sweep(3000, 0, 0, 1));
  EXPECT_NEAR(c.sigma_m, 0.04, 0.002);
  for (double d = 0.7; d < 8.3; d += 0.2) EXPECT_NEAR(c.model.at(d).mean_m, bias(d), 0.01) << d;
  EXPECT_LT(c.too_long + c.too_short, 10);
  EXPECT_EQ(c.correlation.lag_one, 0);
  EXPECT_NEAR(c.lowest_m, 0.5, 0.01);
}

TEST(RangeCalibration, OutliersAreLeftOutAndCounted) {
  const auto c = vir::ranging::calibrateRangeBias(sweep(3000, 0.3, 0, 2));
  EXPECT_NEAR(c.too_long, 900, 60);
  EXPECT_LT(c.too_short, 10);
  EXPECT_NEAR(c.sigma_m, 0.04, 0.004);
  for (double d = 0.7; d < 8.3; d += 0.2) EXPECT_NEAR(c.model.at(d).mean_m, bias(d), 0.015) << d;
}

TEST(RangeCalibration, CorrelatedErrorsWidenTheBand) {
  const auto white = vir::ranging::calibrateRangeBias(sweep(3000, 0, 0, 3));
  const auto slow = vir::ranging::calibrateRangeBias(sweep(3000, 0, 0.86, 3));
  EXPECT_NEAR(slow.correlation.lag_one, 0.86, 0.06);
  EXPECT_GT(slow.model.at(4.5).sigma_m, 1.7 * white.model.at(4.5).sigma_m);
  double chi2 = 0;
  int n = 0;
  for (double d = 0.7; d < 8.3; d += 0.2, ++n) {
    const auto b = slow.model.at(d);
    chi2 += std::pow((b.mean_m - bias(d)) / b.sigma_m, 2);
  }
  EXPECT_LT(chi2 / n, 3);
}

TEST(RangeCalibration, TooLittleOrBadData) {
  EXPECT_THROW(vir::ranging::calibrateRangeBias({}), std::invalid_argument);
  EXPECT_THROW(vir::ranging::calibrateRangeBias(sweep(20, 0, 0, 1)), std::invalid_argument);
  auto samples = sweep(500, 0, 0, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 100; ++i) samples[i].residual_m = i % 2 ? nan : 1e30;
  const auto c = vir::ranging::calibrateRangeBias(samples);
  EXPECT_NEAR(c.sigma_m, 0.04, 0.005);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(c.outlier[i]);
  // One distance only.
  std::vector<CalibrationSample> same(100, {0, 0, 2.0, 0.1});
  EXPECT_NEAR(vir::ranging::calibrateRangeBias(same).model.at(2).mean_m, 0.1, 1e-3);
}

}  // namespace
