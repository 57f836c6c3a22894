#pragma once
/// A rigid transform T_A_B: takes B coordinates to A.
#include "vir/geometry/so3.h"

namespace vir {
inline namespace geometry {

struct Pose {
  Quat q = Quat::Identity();  ///< R_A_B, unit length
  Vec3 p = Vec3::Zero();      ///< origin of B in A [m]

  Pose() = default;
  Pose(const Quat& q_in, const Vec3& p_in) : q(q_in), p(p_in) {}

  Mat3 R() const { return q.toRotationMatrix(); }
  /// T_A_B * T_B_C = T_A_C.
  Pose operator*(const Pose& o) const { return {(q * o.q).normalized(), p + q * o.p}; }
  /// Point in B to point in A.
  Vec3 operator*(const Vec3& x) const { return p + q * x; }
  Pose inverse() const {
    const Quat qi = q.conjugate();
    return {qi, -(qi * p)};
  }
};

/// Rotation about z that is left when roll and pitch are taken off (yaw of a ZYX decomposition)
/// [rad].
double yawOf(const Mat3& R_W_B);

/// Yaw [rad] of the rotation about z that is nearest to `R` (in the Frobenius norm): defined
/// whatever axis of the body points up, unlike yawOf().
double nearestYaw(const Mat3& R);

/// Rotation about z by `yaw` [rad].
Mat3 rotZ(double yaw);

/// A roll-and-pitch-only rotation R_W_B such that R_W_B * up_B points to +z: the attitude of a body
/// that feels the specific force `up_B` at rest. Yaw of the result is 0. `up_B` need not be
/// normalised; throws std::invalid_argument if it is zero.
Quat gravityAlignedAttitude(const Vec3& up_B);

}  // namespace geometry
}  // namespace vir
