#include "vir/runs/pooled_calibration.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vir::runs {
namespace {

/// A run does not take a time offset to be known better than this before it has looked [s].
constexpr double kUnknownOffsetS = 0.03;
/// Of what was assumed; above, the runs have said next to nothing.
constexpr double kObservedShare = 0.8;

using Change = CalibrationChange;
using Matrix = CalibrationCovariance;

Change assumedOf(CalibrationSigma sigma) {
  sigma.time_offset_s = std::max(sigma.time_offset_s, kUnknownOffsetS);
  return covarianceOf(sigma).diagonal().cwiseSqrt();
}

Matrix inverseOf(const Matrix& A) {
  const Matrix symmetric = 0.5 * (A + A.transpose());
  return symmetric.ldlt().solve(Matrix::Identity());
}

/// What a run's data say, without what it assumed: information, and information times change from
/// what was given. In units of what was assumed.
struct Said {
  Matrix information;
  Change vector;
};

Said saidBy(const CalibrationRun& run, const Calibration& given, const Change& unit) {
  const Change per_unit = unit.cwiseInverse();
  const Matrix all = inverseOf(per_unit.asDiagonal() * run.covariance * per_unit.asDiagonal());
  const Change weight = unit.cwiseQuotient(assumedOf(run.assumed)).cwiseAbs2();
  const Change found = changeBetween(given, run.found).cwiseProduct(per_unit);
  const Change began = changeBetween(given, run.given).cwiseProduct(per_unit);
  Matrix information = all;
  information.diagonal() -= weight;
  // Nothing makes a calibration less certain than it was assumed to be.
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(information);
  const Matrix V = eigen.eigenvectors();
  information = V * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * V.transpose();
  return {information, all * found - weight.cwiseProduct(began)};
}

}  // namespace

bool PooledCalibration::observed(int i) const {
  return sigma[i] < kObservedShare * spread[i] * assumed[i];
}

PooledCalibration pooledCalibration(const Calibration& given, const CalibrationSigma& assumed,
                                    const std::vector<CalibrationRun>& runs) {
  if (runs.empty()) throw std::invalid_argument("pooledCalibration: there are no runs");
  PooledCalibration out;
  out.assumed = assumedOf(assumed);
  std::vector<Said> said;
  Matrix information = Matrix::Identity();
  Change vector = Change::Zero();
  for (const CalibrationRun& run : runs) {
    said.push_back(saidBy(run, given, out.assumed));
    information += said.back().information;
    vector += said.back().vector;
  }
  const Matrix covariance = inverseOf(information);
  const Change pooled = covariance * vector;
  const Change variance = covariance.diagonal();

  // Alone, each run would have found x; x - pooled has the variance that the others took away.
  Change disagreement = Change::Zero();
  for (const Said& s : said) {
    const Matrix alone = inverseOf(s.information + Matrix::Identity());
    const Change x = alone * s.vector;
    for (int i = 0; i < kCalibrationSize; ++i) {
      const double taken = std::max(alone(i, i) - variance[i], 0.01 * variance[i]);
      disagreement[i] += std::pow(x[i] - pooled[i], 2) / taken;
    }
  }
  disagreement /= static_cast<double>(runs.size());
  out.spread = Change::Ones();
  if (runs.size() > 1) out.spread = disagreement.cwiseSqrt().cwiseMax(1.0);
  const Change sigma = variance.cwiseSqrt().cwiseProduct(out.spread).cwiseMin(1.0);
  out.spread = sigma.cwiseQuotient(variance.cwiseSqrt()).cwiseMax(1.0);
  out.sigma = sigma.cwiseProduct(out.assumed);
  out.calibration = changed(given, pooled.cwiseProduct(out.assumed));
  return out;
}

double largestChange(const Calibration& a, const Calibration& b, const CalibrationChange& sigma) {
  return changeBetween(a, b).cwiseQuotient(sigma).cwiseAbs().maxCoeff();
}

}  // namespace vir::runs
