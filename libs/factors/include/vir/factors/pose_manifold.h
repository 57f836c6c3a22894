#pragma once
/// Parameter blocks as plain arrays, and the manifold of poses for Ceres.
///
/// pose        [7]  p_W_B [m], q_W_B (x y z w)
/// speed_bias  [9]  v_W_B [m/s], bias gyro [rad/s], bias accelerometer [m/s^2]
/// landmark    [3]  u, v (tangent plane of the host's bearing), inverse distance [1/m]
/// extrinsic   [7]  p_B_C, q_B_C
/// time offset [1]  [s]: image stamp + offset = IMU clock
///
/// Jacobians of poses are written in the 6 local coordinates (position in W, rotation on the right)
/// into the first 6 of 7 columns; the manifold's Plus Jacobian is the matching [I; 0].
#include <ceres/manifold.h>

#include "vir/geometry/pose.h"

namespace vir::factors {

inline Pose poseFrom(const double* x) {
  return {Quat(x[6], x[3], x[4], x[5]), Vec3(x[0], x[1], x[2])};
}
inline void poseTo(const Pose& T, double* x) {
  for (int i = 0; i < 3; ++i) x[i] = T.p[i];
  x[3] = T.q.x();
  x[4] = T.q.y();
  x[5] = T.q.z();
  x[6] = T.q.w();
}

/// y = x + delta for a pose array; delta = (dp in W, dtheta on the right).
inline void posePlus(const double* x, const double* delta, double* y) {
  const Pose T = poseFrom(x);
  const Quat q = (T.q * expQuat(Vec3(delta[3], delta[4], delta[5]))).normalized();
  poseTo({q, T.p + Vec3(delta[0], delta[1], delta[2])}, y);
}

/// delta = y - x for pose arrays.
inline void poseMinus(const double* y, const double* x, double* delta) {
  const Pose Y = poseFrom(y), X = poseFrom(x);
  const Vec3 dtheta = logQuat(X.q.conjugate() * Y.q);
  for (int i = 0; i < 3; ++i) {
    delta[i] = Y.p[i] - X.p[i];
    delta[3 + i] = dtheta[i];
  }
}

class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* y) const override {
    posePlus(x, delta, y);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    poseMinus(y, x, delta);
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

}  // namespace vir::factors
