#include "vir/factors/node_edge_factor.h"

#include <cmath>

#include "range_residual.h"

namespace vir::factors {

void evaluateNodeEdge(const Vec3& motion_O, const Eigen::Matrix4d& W, double sigma_s,
                      const double* node_a, const double* node_b, double* residuals, double* J_a,
                      double* J_b) {
  const Mat3 R_O_W = rotZ(-node_a[3]);
  const Vec3 moved_O = R_O_W * (vec(node_b) - vec(node_a));
  const Vec3 expected_O = std::exp(-node_a[4]) * motion_O;
  Eigen::Vector4d r;
  r << moved_O - expected_O, node_b[3] - node_a[3];
  Eigen::Map<Eigen::Vector4d> whitened(residuals);
  whitened = W * r;
  residuals[4] = (node_b[4] - node_a[4]) / sigma_s;
  using Mat5 = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;
  Eigen::Matrix<double, 4, 5> U;
  if (J_a) {
    U.setZero();
    U.block<3, 3>(0, 0) = -R_O_W;
    U.block<3, 1>(0, 3) = -turned(moved_O);
    U.block<3, 1>(0, 4) = expected_O;
    U(3, 3) = -1;
    Eigen::Map<Mat5> J(J_a);
    J.topRows<4>() = W * U;
    J.row(4) << 0, 0, 0, 0, -1 / sigma_s;
  }
  if (J_b) {
    U.setZero();
    U.block<3, 3>(0, 0) = R_O_W;
    U(3, 3) = 1;
    Eigen::Map<Mat5> J(J_b);
    J.topRows<4>() = W * U;
    J.row(4) << 0, 0, 0, 0, 1 / sigma_s;
  }
}

bool NodeEdgeFactor::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  evaluateNodeEdge(motion_O_, W_, sigma_s_, x[0], x[1], residuals,
                   jacobians ? jacobians[0] : nullptr, jacobians ? jacobians[1] : nullptr);
  return true;
}

}  // namespace vir::factors
