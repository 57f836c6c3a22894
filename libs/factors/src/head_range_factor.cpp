#include "vir/factors/head_range_factor.h"

#include <cmath>

#include "range_residual.h"
#include "vir/factors/pose_manifold.h"

namespace vir::factors {

bool HeadRangeFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  const Pose T0 = poseFrom(x[0]);
  const HeadingChange turned_O(T0.q, q_O_B0_);
  const Mat3 R = rotZ(x[1][3] - turned_O.yaw);
  const double shrink = std::exp(-x[1][4]);
  const Vec3 arm_B = offset_B_ + (shrink - 1) * motion_B_;  // see WindowRangeFactor
  const Vec3 span_W = R * (T0.q * arm_B);
  const RangePrediction r = predictRange(vec(x[1]) + span_W, vec(x[2]), x[2][3], range_.range_m);
  const double scale = whiten(range_, r.value_m, residuals);
  if (!jacobians) return true;
  const Row3 u = scale * r.direction.transpose();
  if (jacobians[0]) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> J(jacobians[0]);
    J.setZero();
    J.segment<3>(3) = -u * R * T0.R() * hat(arm_B) - u.dot(turned(span_W)) * turned_O.by_turn;
  }
  if (jacobians[1]) {
    Eigen::Map<Eigen::Matrix<double, 1, 5>> J(jacobians[1]);
    J << u, u.dot(turned(span_W)), -shrink * u.dot(R * (T0.q * motion_B_));
  }
  if (jacobians[2]) anchorJacobian(scale, r.direction, jacobians[2]);
  return true;
}

}  // namespace vir::factors
