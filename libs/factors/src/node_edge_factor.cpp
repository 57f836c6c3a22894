#include "vir/factors/node_edge_factor.h"

#include <cmath>

#include "range_residual.h"

namespace vir::factors {

bool NodeEdgeFactor::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  const Mat3 R_O_W = rotZ(-x[0][3]);
  const Vec3 moved_O = R_O_W * (vec(x[1]) - vec(x[0]));
  const Vec3 expected_O = std::exp(-x[0][4]) * motion_O_;
  Eigen::Vector4d r;
  r << moved_O - expected_O, x[1][3] - x[0][3];
  Eigen::Map<Eigen::Vector4d> whitened(residuals);
  whitened = W_ * r;
  residuals[4] = (x[1][4] - x[0][4]) / sigma_s_;
  if (!jacobians) return true;
  using Mat5 = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;
  Eigen::Matrix<double, 4, 5> U;
  if (jacobians[0]) {
    U.setZero();
    U.block<3, 3>(0, 0) = -R_O_W;
    U.block<3, 1>(0, 3) = -turned(moved_O);
    U.block<3, 1>(0, 4) = expected_O;
    U(3, 3) = -1;
    Eigen::Map<Mat5> J(jacobians[0]);
    J.topRows<4>() = W_ * U;
    J.row(4) << 0, 0, 0, 0, -1 / sigma_s_;
  }
  if (jacobians[1]) {
    U.setZero();
    U.block<3, 3>(0, 0) = R_O_W;
    U(3, 3) = 1;
    Eigen::Map<Mat5> J(jacobians[1]);
    J.topRows<4>() = W_ * U;
    J.row(4) << 0, 0, 0, 0, 1 / sigma_s_;
  }
  return true;
}

}  // namespace vir::factors
