#include "vir/ranging/gaussian_process.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "vir_test_noise.h"

namespace {

using vir::ranging::GaussianProcess;
using vir::ranging::GaussianProcessOptions;

double truth(double x) { return 0.1 + 0.05 * std::sin(0.9 * x); }

void draw(int n, double noise_sigma, int seed, std::vector<double>* x, std::vector<double>* y) {
  vir::test::Noise noise(seed);
  for (int i = 0; i < n; ++i) {
    x->push_back(0.5 + 9.5 * noise.uniform());
    y->push_back(truth(x->back()) + noise_sigma * noise.normal());
  }
}

TEST(GaussianProcess, GradientAgreesWithDifferences) {
  std::vector<double> x, y;
  draw(600, 0.02, 1, &x, &y);  // binned
  const GaussianProcess process(x, y);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(-3, 0.5, -4), Eigen::Vector3d(-2, -0.5, -3)}) {
    Eigen::Vector3d gradient;
    process.logLikelihood(at, &gradient);
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3d step = Eigen::Vector3d::Zero();
      step[k] = 1e-5;
      const double numeric =
          (process.logLikelihood(at + step, nullptr) - process.logLikelihood(at - step, nullptr)) /
          2e-5;
      EXPECT_NEAR(gradient[k], numeric, 1e-4 * (1 + std::abs(numeric))) << k;
    }
  }
}

TEST(GaussianProcess, FindsCurveAndNoise) {
  for (const int n : {60, 3000}) {
    std::vector<double> x, y;
    draw(n, 0.03, 2, &x, &y);
    const GaussianProcess process(x, y);
    EXPECT_NEAR(process.hyper().noise, 0.03, n > 100 ? 0.002 : 0.008);
    for (double d = 1; d < 9.5; d += 0.25) {
      const auto p = process.predict(d);
      EXPECT_NEAR(p.mean, truth(d), 4 * p.sigma + 1e-4) << n << " " << d;
      EXPECT_LT(p.sigma, n > 100 ? 0.006 : 0.03);
    }
  }
}

TEST(GaussianProcess, TheBandHoldsTheTruth) {
  double chi2 = 0;
  constexpr int kSeeds = 40;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::vector<double> x, y;
    draw(250, 0.03, 100 + seed, &x, &y);
    const auto p = GaussianProcess(x, y).predict(4.0);
    chi2 += std::pow((p.mean - truth(4.0)) / p.sigma, 2) / kSeeds;
  }
  EXPECT_GT(chi2, 0.4);
  EXPECT_LT(chi2, 2.0);
}

TEST(GaussianProcess, FarFromSamplesItFallsBackOnTheMeanAndSaysSo) {
  std::vector<double> x, y;
  draw(300, 0.02, 3, &x, &y);
  const GaussianProcess process(x, y);
  const auto far = process.predict(1000);
  EXPECT_NEAR(far.mean, process.hyper().mean, 1e-6);
  EXPECT_GE(far.sigma, process.hyper().signal);
  EXPECT_GT(far.sigma, 5 * process.predict(5).sigma);
}

TEST(GaussianProcess, CorrelatedSamplesAreWorthLess) {
  std::vector<double> x, y;
  draw(1000, 0.03, 4, &x, &y);
  GaussianProcessOptions options;
  const double white = GaussianProcess(x, y, options).predict(5).sigma;
  options.correlation_factor = 10;
  EXPECT_GT(GaussianProcess(x, y, options).predict(5).sigma, 1.7 * white);
}

TEST(GaussianProcess, DegenerateData) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(GaussianProcess({1, 2}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(GaussianProcess({1, 2, 3}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(GaussianProcess({1, 2, nan}, {1, 2, 3}), std::invalid_argument);
  // All at one place, all the same, exactly on a line: finite answers.
  for (const auto& [x, y] : {std::pair<std::vector<double>, std::vector<double>>{
                                 std::vector<double>(50, 2.0), std::vector<double>(50, 0.1)},
                             {{1, 2, 3, 4}, {0.1, 0.1, 0.1, 0.1}},
                             {{1, 2, 3, 4, 5}, {0.1, 0.2, 0.3, 0.4, 0.5}}}) {
    const GaussianProcess process(x, y);
    const auto p = process.predict(2);
    EXPECT_NEAR(p.mean, y[1], 0.01);
    EXPECT_TRUE(std::isfinite(p.sigma));
  }
}

}  // namespace
