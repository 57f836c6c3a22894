#include "vir/factors/level_edge_factor.h"

#include <cmath>

#include "range_residual.h"

namespace vir::factors {
namespace {

using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * M_PI); }

}  // namespace

bool LevelEdgeFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  const Mat3 R_W_M = rotZ(-x[0][3]);
  const Vec3 moved_W = R_W_M * (vec(x[1]) - vec(x[0]));
  Eigen::Vector4d r;
  r << moved_W - motion_W_, wrapped(x[1][3] - x[0][3] - turn_rad_);
  Eigen::Map<Eigen::Vector4d> whitened(residuals);
  whitened = W_ * r;
  if (!jacobians) return true;
  Eigen::Matrix4d U = Eigen::Matrix4d::Identity();
  if (jacobians[0]) {
    U.topLeftCorner<3, 3>() = -R_W_M;
    U.topRightCorner<3, 1>() = -turned(moved_W);
    U(3, 3) = -1;
    Eigen::Map<RowMajor4> J(jacobians[0]);
    J = W_ * U;
  }
  if (jacobians[1]) {
    U.setIdentity();
    U.topLeftCorner<3, 3>() = R_W_M;
    Eigen::Map<RowMajor4> J(jacobians[1]);
    J = W_ * U;
  }
  return true;
}

}  // namespace vir::factors
