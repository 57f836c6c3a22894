#pragma once
/// SO(3): exponential, logarithm and Jacobians. Hamilton quaternions; a rotation R_A_B takes B
/// coordinates to A; perturbations act on the right: R * Exp(dtheta). Angles in rad.
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace vir {
inline namespace geometry {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Mat23 = Eigen::Matrix<double, 2, 3>;
using Quat = Eigen::Quaterniond;

/// Skew-symmetric matrix: hat(a) * b = a x b.
Mat3 hat(const Vec3& a);

/// Unit quaternion of the rotation vector `theta` [rad]; exact series near zero.
Quat expQuat(const Vec3& theta);

/// Rotation matrix of the rotation vector `theta` [rad].
Mat3 expSO3(const Vec3& theta);

/// Rotation vector [rad] in the ball of radius pi. `q` need not be in the w >= 0 half; it must be
/// close to unit length.
Vec3 logQuat(const Quat& q);
Vec3 logSO3(const Mat3& R);

/// Right Jacobian: Exp(theta + d) ~ Exp(theta) Exp(Jr(theta) d).
Mat3 rightJacobianSO3(const Vec3& theta);

/// Inverse of the right Jacobian: Log(R Exp(d)) ~ Log(R) + Jr^-1(Log(R)) d. Finite up to |theta| =
/// pi; singular at 2 pi only.
Mat3 rightJacobianInverseSO3(const Vec3& theta);

}  // namespace geometry
}  // namespace vir
