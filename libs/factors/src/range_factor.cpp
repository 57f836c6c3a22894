#include "vir/factors/range_factor.h"

#include <cmath>

#include "vir/factors/pose_manifold.h"

namespace vir::factors {
namespace {

using Row3 = Eigen::Matrix<double, 1, 3>;

Vec3 vec(const double* x) { return {x[0], x[1], x[2]}; }

/// d(Rz(yaw) v)/d(yaw), given v already turned.
Vec3 turned(const Vec3& v_W) { return {-v_W.y(), v_W.x(), 0}; }

/// Whitens and robustifies; returns d(residual)/d(unwhitened residual).
double finish(const RangeTerm& range, double unwhitened_m, double* residuals) {
  // The robust loss knows measured - predicted, the residual is predicted - measured.
  const ranging::RobustRange::Value v = range.robust.evaluate(-unwhitened_m / range.sigma_m);
  residuals[0] = -v.e;
  return v.de_dr / range.sigma_m;
}

void anchorJacobian(double scale, const Vec3& direction, double* j) {
  for (int i = 0; i < 3; ++i) j[i] = -scale * direction[i];
  j[3] = scale;
}

}  // namespace

RangePrediction predictRange(const Vec3& p_W_U, const Vec3& p_W_A, double bias_m, double range_m) {
  const Vec3 d = p_W_U - p_W_A;
  const double distance = d.norm();
  RangePrediction out;
  out.value_m = distance + bias_m - range_m;
  out.direction = d / std::max(distance, kMinDistance);
  return out;
}

bool NodeRangeFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  const Mat3 R = rotZ(x[0][3]);
  const double shrink = std::exp(-x[0][4]);
  const Vec3 motion_W = R * (shrink * motion_O_);
  const Vec3 offset_W = motion_W + R * lever_O_;
  const RangePrediction r = predictRange(vec(x[0]) + offset_W, vec(x[1]), x[1][3], range_.range_m);
  const double scale = finish(range_, r.value_m, residuals);
  if (!jacobians) return true;
  if (jacobians[0]) {
    for (int i = 0; i < 3; ++i) jacobians[0][i] = scale * r.direction[i];
    jacobians[0][3] = scale * r.direction.dot(turned(offset_W));
    jacobians[0][4] = -scale * r.direction.dot(motion_W);
  }
  if (jacobians[1]) anchorJacobian(scale, r.direction, jacobians[1]);
  return true;
}

bool WindowRangeFactor::Evaluate(double const* const* x, double* residuals,
                                 double** jacobians) const {
  const Pose T0 = poseFrom(x[0]), Tj = poseFrom(x[1]);
  const Mat3 R = rotZ(x[2][3]);
  const Vec3 span_W = R * (Tj.p + Tj.q * offset_B_ - T0.p);
  const RangePrediction r = predictRange(vec(x[2]) + span_W, vec(x[3]), x[3][3], range_.range_m);
  const double scale = finish(range_, r.value_m, residuals);
  if (!jacobians) return true;
  const Row3 u = scale * r.direction.transpose();
  const Row3 u_O = u * R;
  if (jacobians[0]) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> J(jacobians[0]);
    J.setZero();
    J.head<3>() = -u_O;
  }
  if (jacobians[1]) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> J(jacobians[1]);
    J.setZero();
    J.head<3>() = u_O;
    J.segment<3>(3) = -u_O * Tj.R() * hat(offset_B_);
  }
  if (jacobians[2]) {
    Eigen::Map<Eigen::Matrix<double, 1, 5>> J(jacobians[2]);
    J << u, u.dot(turned(span_W)), 0;
  }
  if (jacobians[3]) anchorJacobian(scale, r.direction, jacobians[3]);
  return true;
}

bool FrontRangeFactor::Evaluate(double const* const* x, double* residuals,
                                double** jacobians) const {
  const Pose T0 = poseFrom(x[0]);
  const Mat3 R = rotZ(x[1][3]);
  const Vec3 span_W = R * (T0.q * offset_B_);
  const RangePrediction r = predictRange(vec(x[1]) + span_W, vec(x[2]), x[2][3], range_.range_m);
  const double scale = finish(range_, r.value_m, residuals);
  if (!jacobians) return true;
  const Row3 u = scale * r.direction.transpose();
  if (jacobians[0]) {
    Eigen::Map<Eigen::Matrix<double, 1, 7>> J(jacobians[0]);
    J.setZero();
    J.segment<3>(3) = -u * R * T0.R() * hat(offset_B_);
  }
  if (jacobians[1]) {
    Eigen::Map<Eigen::Matrix<double, 1, 5>> J(jacobians[1]);
    J << u, u.dot(turned(span_W)), 0;
  }
  if (jacobians[2]) anchorJacobian(scale, r.direction, jacobians[2]);
  return true;
}

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
