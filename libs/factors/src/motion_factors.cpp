#include "vir/factors/motion_factors.h"

#include "vir/factors/pose_manifold.h"

namespace vir::factors {

bool ZeroVelocityFactor::Evaluate(double const* const* x, double* residuals,
                                  double** jacobians) const {
  for (int i = 0; i < 3; ++i) residuals[i] = weight_ * x[0][i];
  if (jacobians && jacobians[0]) {
    Eigen::Map<Eigen::Matrix<double, 3, 9, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
    J.leftCols<3>() = weight_ * Mat3::Identity();
  }
  return true;
}

bool RelativePoseFactor::Evaluate(double const* const* x, double* residuals,
                                  double** jacobians) const {
  const Pose Ti = poseFrom(x[0]), Tj = poseFrom(x[1]);
  const Quat qit = Ti.q.conjugate();
  const Vec3 dp = qit * (Tj.p - Ti.p);
  Eigen::Matrix<double, 6, 1> r;
  r.head<3>() = dp - z_.p;
  r.tail<3>() = logQuat(z_.q.conjugate() * (qit * Tj.q));
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(residuals).noalias() = W_ * r;
  if (!jacobians) return true;
  const Mat3 Jr_inv = rightJacobianInverseSO3(r.tail<3>());
  const Mat3 RiT = qit.toRotationMatrix();
  using RowMajor6x7 = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;
  if (jacobians[0]) {
    RowMajor6x7 U = RowMajor6x7::Zero();
    U.block<3, 3>(0, 0) = -RiT;
    U.block<3, 3>(0, 3) = hat(dp);
    U.block<3, 3>(3, 3) = -Jr_inv * (Tj.q.conjugate() * Ti.q).toRotationMatrix();
    Eigen::Map<RowMajor6x7>(jacobians[0]).noalias() = W_ * U;
  }
  if (jacobians[1]) {
    RowMajor6x7 U = RowMajor6x7::Zero();
    U.block<3, 3>(0, 0) = RiT;
    U.block<3, 3>(3, 3) = Jr_inv;
    Eigen::Map<RowMajor6x7>(jacobians[1]).noalias() = W_ * U;
  }
  return true;
}

}  // namespace vir::factors
