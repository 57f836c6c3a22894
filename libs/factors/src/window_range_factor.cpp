#include "vir/factors/window_range_factor.h"

#include <cmath>

#include "range_residual.h"
#include "vir/factors/pose_manifold.h"

namespace vir::factors {

HeadingChange::HeadingChange(const Quat& q_O_B, const std::optional<Quat>& was_O_B) {
  if (!was_O_B) return;
  const Mat3 M = (q_O_B * was_O_B->conjugate()).toRotationMatrix();
  const double a = M(1, 0) - M(0, 1), b = M(0, 0) + M(1, 1), n = a * a + b * b;
  if (!(n > 0)) return;
  yaw = nearestYaw(M);
  const Row3 by_turn_O((a * M(2, 1) - b * M(2, 0)) / n, -(a * M(2, 0) + b * M(2, 1)) / n, 1);
  by_turn = by_turn_O * q_O_B.toRotationMatrix();
}

bool WindowRangeFactor::Evaluate(double const* const* x, double* residuals,
                                 double** jacobians) const {
  const Pose T0 = poseFrom(x[0]), Tj = poseFrom(x[1]);
  const HeadingChange turned_O(T0.q, q_O_B0_);
  const Mat3 R = rotZ(x[2][3] - turned_O.yaw);
  // The way is as long as the odometry's metre, the lever is not. Written as what the scale takes
  // off, so that a scale that is held at 1 changes no digit.
  const double shrink = std::exp(-x[2][4]), off = shrink - 1;
  const Vec3 span_O = Tj.p + Tj.q * offset_B_ - T0.p;
  const Vec3 way_O = span_O - Tj.q * lever_B_;
  const Vec3 span_W = R * Vec3(span_O + off * way_O);
  const RangePrediction r = predictRange(vec(x[2]) + span_W, vec(x[3]), x[3][3], range_.range_m);
  const double scale = whiten(range_, r.value_m, residuals);
  if (!jacobians) return true;
  const Row3 u = scale * r.direction.transpose();
  const Row3 u_O = u * R;
  if (jacobians[0]) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> J(jacobians[0]);
    J.setZero();
    J.head<3>() = -shrink * u_O;
    J.segment<3>(3) = -u.dot(turned(span_W)) * turned_O.by_turn;
  }
  if (jacobians[1]) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> J(jacobians[1]);
    J.setZero();
    J.head<3>() = shrink * u_O;
    J.segment<3>(3) = -u_O * Tj.R() * hat(offset_B_ + off * motion_B_);
  }
  if (jacobians[2]) {
    Eigen::Map<Eigen::Matrix<double, 1, 5>> J(jacobians[2]);
    J << u, u.dot(turned(span_W)), -shrink * u_O.dot(way_O);
  }
  if (jacobians[3]) anchorJacobian(scale, r.direction, jacobians[3]);
  return true;
}

}  // namespace vir::factors
