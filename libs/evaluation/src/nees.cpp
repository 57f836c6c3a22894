#include "vir/evaluation/nees.h"

#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>

namespace vir::evaluation {
namespace {

/// Regularised lower incomplete gamma function by its power series, which converges for all x.
double gammaP(double a, double x) {
  if (x <= 0) return 0;
  double term = 1.0 / a;
  double sum = term;
  for (int n = 1; n < 100000; ++n) {
    term *= x / (a + n);
    sum += term;
    if (term < sum * 1e-17) break;
  }
  return std::exp(a * std::log(x) - x - std::lgamma(a)) * sum;
}

}  // namespace

bool nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance, double* value) {
  *value = 0;
  if (covariance.rows() != error.size() || covariance.cols() != error.size()) return false;
  if (!error.allFinite() || !covariance.allFinite()) return false;
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) return false;
  const double result = error.dot(llt.solve(error));
  if (!std::isfinite(result)) return false;
  *value = result;
  return true;
}

Eigen::Matrix<double, 6, 1> poseError(const Pose& T_W_B_reference, const Pose& T_W_B_estimate) {
  Eigen::Matrix<double, 6, 1> e;
  e.head<3>() = T_W_B_estimate.p - T_W_B_reference.p;
  e.tail<3>() = logQuat(T_W_B_reference.q.conjugate() * T_W_B_estimate.q);
  return e;
}

Pose gaugeAt(const Pose& T_R_B, const Pose& T_E_B) {
  const Mat3 R = rotZ(nearestYaw(T_R_B.R() * T_E_B.R().transpose()));
  return {Quat(R), T_R_B.p - R * T_E_B.p};
}

double chiSquareQuantile(int dof, double p) {
  if (dof < 1 || !(p > 0 && p < 1)) {
    throw std::invalid_argument("chiSquareQuantile: needs dof >= 1 and 0 < p < 1");
  }
  const double a = 0.5 * dof;
  double low = 0, high = dof;
  while (gammaP(a, 0.5 * high) < p && high < 1e6) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-13 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (gammaP(a, 0.5 * middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

NeesSummary summariseNees(const std::vector<double>& values, int dof) {
  NeesSummary s;
  s.count = static_cast<long>(values.size());
  if (values.empty()) return s;
  const double bound = chiSquareQuantile(dof, 0.95);
  for (const double v : values) {
    s.mean_per_dof += v / (dof * static_cast<double>(values.size()));
    s.share_below_95 += (v < bound ? 1.0 : 0.0) / static_cast<double>(values.size());
  }
  return s;
}

}  // namespace vir::evaluation
