#include "vir/factors/position_link_factor.h"

namespace vir::factors {

bool PositionLinkFactor::Evaluate(double const* const* x, double* residuals,
                                  double** jacobians) const {
  for (int i = 0; i < 3; ++i) residuals[i] = gamma_s_ * (x[1][i] - x[0][i] - z_W_[i]);
  if (!jacobians) return true;
  for (int k = 0; k < 2; ++k) {
    if (!jacobians[k]) continue;
    Eigen::Map<Eigen::Matrix<double, 3, 5, Eigen::RowMajor>> J(jacobians[k]);
    J.setZero();
    J.leftCols<3>() = (k ? gamma_s_ : -gamma_s_) * Mat3::Identity();
  }
  return true;
}

}  // namespace vir::factors
