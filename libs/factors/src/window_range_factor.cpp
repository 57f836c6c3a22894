#include "vir/factors/window_range_factor.h"

#include <cmath>

#include "range_residual.h"
#include "vir/factors/pose_manifold.h"

namespace vir::factors {

bool WindowRangeFactor::Evaluate(double const* const* x, double* residuals,
                                 double** jacobians) const {
  const Pose T0 = poseFrom(x[0]), Tj = poseFrom(x[1]);
  const Mat3 R = rotZ(x[2][3]);
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
