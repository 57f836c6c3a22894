#include "vir/ranging/range_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "vir_test_noise.h"

namespace {

using vir::ranging::RangeResidual;
constexpr vir::TimeNs kStep = 50'000'000;

/// AR(1) with unit variance, share 1 - `white`, under white noise, times `size`.
std::vector<RangeResidual> drawn(int n, double rho, double white, double size, int seed) {
  vir::test::Noise noise(seed);
  std::vector<RangeResidual> out;
  double x = noise.normal();
  for (int i = 0; i < n; ++i) {
    x = rho * x + std::sqrt(1 - rho * rho) * noise.normal();
    const double r = std::sqrt(1 - white) * x + std::sqrt(white) * noise.normal();
    out.push_back({i * kStep, 0.05 * size * r, 0.05});
  }
  return out;
}

TEST(RangeCorrelation, WhiteNoiseKeepsItsWorth) {
  double sum = 0;
  for (int seed = 0; seed < 50; ++seed) {
    const auto c = vir::ranging::rangeCorrelation(drawn(1000, 0, 0, 1, seed));
    EXPECT_LT(c.lag_one, 0.12);
    sum += c.variance_factor / 50;
  }
  EXPECT_NEAR(sum, 1.0, 0.05);
}

TEST(RangeCorrelation, AutoregressiveNoise) {
  for (const double rho : {0.5, 0.86}) {
    double lag = 0, factor = 0;
    for (int seed = 0; seed < 50; ++seed) {
      const auto c = vir::ranging::rangeCorrelation(drawn(2000, rho, 0, 1, seed));
      lag += c.lag_one / 50;
      factor += c.correlation_factor / 50;
    }
    EXPECT_NEAR(lag, rho, 0.02);
    const double truth = (1 + rho) / (1 - rho);
    EXPECT_NEAR(factor, truth, 0.15 * truth) << rho;
  }
}

TEST(RangeCorrelation, SlowErrorsUnderWhiteNoise) {
  // Half the variance is white: from one range to the next only 0.45, but it stays long.
  double factor = 0;
  for (int seed = 0; seed < 50; ++seed) {
    factor +=
        vir::ranging::rangeCorrelation(drawn(4000, 0.9, 0.5, 1, seed)).correlation_factor / 50;
  }
  const double truth = 1 + 2 * 0.5 * 0.9 / (1 - 0.9);  // 10, (1+rho)/(1-rho) would say 2.6
  EXPECT_NEAR(factor, truth, 0.2 * truth);
}

TEST(RangeCorrelation, LargerThanClaimed) {
  const auto c = vir::ranging::rangeCorrelation(drawn(2000, 0, 0, 3, 1));
  EXPECT_NEAR(c.rms_ratio, 3, 0.15);
  EXPECT_NEAR(c.variance_factor, 9, 1);
  // Smaller than claimed never makes ranges worth more.
  EXPECT_EQ(vir::ranging::rangeCorrelation(drawn(2000, 0, 0, 0.3, 1)).variance_factor, 1);
}

TEST(RangeCorrelation, OutliersAndGapsDoNotHideIt) {
  auto series = drawn(3000, 0.8, 0, 1, 3);
  vir::test::Noise noise(5);
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (noise.uniform() < 0.02) series[i].residual_m += 2;
    series[i].t += static_cast<vir::TimeNs>(i / 10) * 100 * kStep;  // a hole every ten ranges
  }
  const auto c = vir::ranging::rangeCorrelation(series);
  // Cut to 3 sigma, the outliers add 0.16 of white variance.
  EXPECT_NEAR(c.lag_one, 0.66, 0.08);
  EXPECT_EQ(c.pairs, 2700);
}

TEST(RangeCorrelation, LimitsAndDegenerateInput) {
  EXPECT_EQ(vir::ranging::rangeCorrelation({}).variance_factor, 1);
  EXPECT_EQ(vir::ranging::rangeCorrelation({{0, 1, 0.1}}).variance_factor, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<RangeResidual> constant, zero, bad;
  for (int i = 0; i < 100; ++i) {
    constant.push_back({i * kStep, 0.5, 1.0});
    zero.push_back({i * kStep, 0, 1.0});
    bad.push_back({i * kStep, i % 2 ? nan : 1.0, i % 2 ? 1.0 : 0.0});
  }
  EXPECT_EQ(vir::ranging::rangeCorrelation(constant).correlation_factor, 30);
  EXPECT_EQ(vir::ranging::rangeCorrelation(zero).variance_factor, 1);
  EXPECT_EQ(vir::ranging::rangeCorrelation(bad).pairs, 0);
  EXPECT_EQ(vir::ranging::rangeCorrelation(bad).variance_factor, 1);
}

}  // namespace
