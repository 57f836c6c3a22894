#include "vir/evaluation/nees.h"

#include <Eigen/Dense>
#include <cmath>

namespace vir::evaluation {

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

Pose gaugeAt(const Pose& T_R_B, const Pose& T_E_B) {
  const Mat3 R = rotZ(nearestYaw(T_R_B.R() * T_E_B.R().transpose()));
  return {Quat(R), T_R_B.p - R * T_E_B.p};
}

double meanNeesPerDof(const std::vector<double>& values, int dof) {
  double mean = 0;
  for (const double v : values) mean += v / (dof * static_cast<double>(values.size()));
  return mean;
}

}  // namespace vir::evaluation
