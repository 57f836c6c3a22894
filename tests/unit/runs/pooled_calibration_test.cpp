#include "vir/runs/pooled_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "vir_test_noise.h"

namespace vir::runs {
namespace {

using Change = CalibrationChange;
using Matrix = CalibrationCovariance;

Calibration given() {
  Calibration c;
  c.camera = {752, 480, 460, 460, 376, 240};
  return c;
}

/// What is assumed, with what a run takes of the clock before it has looked.
Change assumed() {
  Change s = covarianceOf(CalibrationSigma()).diagonal().cwiseSqrt();
  s[6] = 0.03;
  return s;
}

/// A run whose data know `truth` (a change from given()) with `sigma`, plus `error`, and which
/// began at `from` with what is assumed about it.
CalibrationRun runOf(const Change& truth, const Change& sigma, const Change& error,
                     const Change& from = Change::Zero()) {
  const Change data = sigma.cwiseAbs2().cwiseInverse();
  const Change prior = assumed().cwiseAbs2().cwiseInverse();
  const Change variance = (data + prior).cwiseInverse();
  const Change x =
      variance.cwiseProduct(data.cwiseProduct(truth + error) + prior.cwiseProduct(from));
  return {changed(given(), from), CalibrationSigma(), changed(given(), x), variance.asDiagonal()};
}

Change tenthOfAssumed() { return 0.1 * assumed(); }

TEST(PooledCalibration, OneRunIsWhatItFound) {
  const CalibrationRun run = runOf(0.5 * assumed(), tenthOfAssumed(), Change::Zero());
  const PooledCalibration p = pooledCalibration(given(), CalibrationSigma(), {run});
  EXPECT_LT(largestChange(run.found, p.calibration, p.sigma), 1e-6);
  EXPECT_LT((p.sigma - run.covariance.diagonal().cwiseSqrt()).cwiseQuotient(p.sigma).norm(), 1e-6);
  EXPECT_EQ(p.spread, Change(Change::Ones()));
  for (int i = 0; i < kCalibrationSize; ++i) EXPECT_TRUE(p.observed(i)) << i;
}

TEST(PooledCalibration, WhatIsAssumedCountsOnceWhereverARunBegan) {
  const Change truth = 0.5 * assumed(), sigma = 0.5 * assumed();
  const CalibrationRun first = runOf(truth, sigma, Change::Zero());
  const CalibrationRun again =
      runOf(truth, sigma, Change::Zero(), changeBetween(given(), first.found));
  EXPECT_GT(largestChange(first.found, again.found, sigma), 0.1) << "began nearer";
  const PooledCalibration a = pooledCalibration(given(), CalibrationSigma(), {first});
  const PooledCalibration b = pooledCalibration(given(), CalibrationSigma(), {again});
  EXPECT_LT(largestChange(a.calibration, b.calibration, sigma), 1e-3);
  EXPECT_LT((a.sigma - b.sigma).norm(), 1e-9);
}

TEST(PooledCalibration, InformationAddsUp) {
  const Change truth = 0.5 * assumed();
  const CalibrationRun run = runOf(truth, tenthOfAssumed(), Change::Zero());
  const PooledCalibration p = pooledCalibration(given(), CalibrationSigma(), {run, run, run, run});
  for (int i = 0; i < kCalibrationSize; ++i) {
    EXPECT_NEAR(p.sigma[i] / assumed()[i], 1 / std::sqrt(401.0), 1e-6) << i;
  }
  EXPECT_LT(largestChange(changed(given(), truth), p.calibration, p.sigma), 0.1);
}

TEST(PooledCalibration, TheSurerRunCountsMore) {
  const Change sigma = tenthOfAssumed(), off = 0.2 * assumed();
  const PooledCalibration p = pooledCalibration(
      given(), CalibrationSigma(),
      {runOf(Change::Zero(), 0.1 * sigma, Change::Zero()), runOf(Change::Zero(), sigma, off)});
  const Change x = changeBetween(given(), p.calibration).cwiseQuotient(off);
  for (int i = 0; i < kCalibrationSize; ++i) EXPECT_NEAR(x[i], 1.0 / 101, 1e-3) << i;
}

TEST(PooledCalibration, RunsThatDisagreeAreLessSure) {
  const Change sigma = 0.01 * assumed();
  Change error = Change::Zero();
  error[6] = 10 * sigma[6];
  const PooledCalibration p = pooledCalibration(
      given(), CalibrationSigma(),
      {runOf(Change::Zero(), sigma, error), runOf(Change::Zero(), sigma, -error)});
  EXPECT_NEAR(p.spread[6], 10 * std::sqrt(2.0), 0.2);
  EXPECT_NEAR(p.sigma[6] / sigma[6], 10, 0.2);
  EXPECT_NEAR(p.spread[8], 1, 1e-9) << "the others agree";
  EXPECT_TRUE(p.observed(6));
}

TEST(PooledCalibration, WhatNoRunSeesStaysWhereItWas) {
  Change sigma = tenthOfAssumed();
  sigma[2] = 100 * assumed()[2];
  const CalibrationRun run = runOf(0.5 * assumed(), sigma, Change::Zero());
  const PooledCalibration p = pooledCalibration(given(), CalibrationSigma(), {run, run});
  EXPECT_FALSE(p.observed(2));
  EXPECT_TRUE(p.observed(3));
  EXPECT_NEAR(p.sigma[2], assumed()[2], 1e-4 * assumed()[2]);
  EXPECT_NEAR(p.calibration.T_B_C.p.z(), 0, 1e-3 * assumed()[2]);
}

TEST(PooledCalibration, ErrorsStayWithinTheirSigmas) {
  test::Noise noise(3);
  double chi2 = 0;
  constexpr int kTrials = 50;
  for (int trial = 0; trial < kTrials; ++trial) {
    Change truth;
    for (int i = 0; i < kCalibrationSize; ++i) truth[i] = assumed()[i] * noise.normal();
    std::vector<CalibrationRun> runs;
    for (const double share : {0.3, 0.6, 2.0}) {
      Change error;
      for (int i = 0; i < kCalibrationSize; ++i) error[i] = share * assumed()[i] * noise.normal();
      runs.push_back(runOf(truth, share * assumed(), error));
    }
    const PooledCalibration p = pooledCalibration(given(), CalibrationSigma(), runs);
    const Change e = changeBetween(given(), p.calibration) - truth;
    // Angles and lengths of this size do not simply add.
    chi2 += e.cwiseQuotient(p.sigma).squaredNorm() / kCalibrationSize / kTrials;
  }
  EXPECT_GT(chi2, 0.5);
  EXPECT_LT(chi2, 1.15);
}

TEST(PooledCalibration, NoRunsIsAnError) {
  EXPECT_THROW(pooledCalibration(given(), CalibrationSigma(), {}), std::invalid_argument);
}

}  // namespace
}  // namespace vir::runs
