#include "vir/factors/drift_edge_factor.h"

namespace vir::factors {

bool DriftEdgeFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  edge_.Evaluate(x, residuals, jacobians);
  Eigen::Map<Eigen::Vector4d>(residuals).noalias() -=
      weight_ * (x[2][0] * metres_ + x[2][1] * turn_rad_);
  if (jacobians && jacobians[2]) {
    Eigen::Map<Eigen::Matrix<double, 5, 2, Eigen::RowMajor>> J(jacobians[2]);
    J.topRows<4>().col(0) = -metres_ * weight_;
    J.topRows<4>().col(1) = -turn_rad_ * weight_;
    J.row(4).setZero();
  }
  return true;
}

}  // namespace vir::factors
