#pragma once
/// Internal: level transforms with a covariance of (offset in the axes of the first frame [m], turn
/// [rad]).
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "vir/geometry/level_transform.h"

namespace vir::mission {

struct LevelGuess {
  LevelTransform T;
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
};

inline LevelGuess operator*(const LevelGuess& A, const LevelGuess& B) {
  Eigen::Matrix4d J_A = Eigen::Matrix4d::Identity(), J_B = J_A;
  J_B.topLeftCorner<3, 3>() = rotZ(A.T.yaw_rad);
  J_A.topRightCorner<3, 1>() = Vec3::UnitZ().cross(J_B.topLeftCorner<3, 3>() * B.T.t_m);
  return {A.T * B.T, J_A * A.P * J_A.transpose() + J_B * B.P * J_B.transpose()};
}

inline LevelGuess inverse(const LevelGuess& A) {
  const LevelTransform T = A.T.inverse();
  Eigen::Matrix4d J = Eigen::Matrix4d::Zero();
  J.topLeftCorner<3, 3>() = -rotZ(-A.T.yaw_rad);
  J.topRightCorner<3, 1>() = -Vec3::UnitZ().cross(T.t_m);
  J(3, 3) = -1;
  return {T, J * A.P * J.transpose()};
}

/// Do the two say the same? Chi-square of four degrees of freedom.
inline double chiSquare(const LevelGuess& A, const LevelGuess& B) {
  Eigen::Vector4d d;
  d << A.T.t_m - B.T.t_m, std::remainder(A.T.yaw_rad - B.T.yaw_rad, 2 * M_PI);
  const Eigen::Matrix4d S = A.P + B.P;
  return d.dot(S.ldlt().solve(d));
}

}  // namespace vir::mission
