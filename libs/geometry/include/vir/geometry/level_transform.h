#pragma once
/// Between frames that both have z up: a turn about z and an offset, and the fit of the two to
/// points that are known in both.
#include <Eigen/Core>
#include <vector>

#include "vir/geometry/pose.h"

namespace vir {
inline namespace geometry {

/// p_A = Rz(yaw) p_B + t.
struct LevelTransform {
  double yaw_rad = 0;
  Vec3 t_m = Vec3::Zero();

  Vec3 operator*(const Vec3& p_B) const { return rotZ(yaw_rad) * p_B + t_m; }
  Pose pose() const { return {Quat(rotZ(yaw_rad)), t_m}; }
  LevelTransform inverse() const { return {-yaw_rad, -(rotZ(-yaw_rad) * t_m)}; }
  /// T_A_B * T_B_C = T_A_C.
  LevelTransform operator*(const LevelTransform& o) const {
    return {yaw_rad + o.yaw_rad, rotZ(yaw_rad) * o.t_m + t_m};
  }
};

/// A point in both frames.
struct LevelPair {
  Vec3 p_A = Vec3::Zero(), p_B = Vec3::Zero();  ///< [m]
  double weight = 1;                            ///< 1 / variance [1/m^2]
};

/// The transform that lays one set of points onto the other with the least weighted squares.
struct LevelFit {
  LevelTransform T_A_B;
  Vec3 centre_B = Vec3::Zero();  ///< weighted mean of the points in B
  double weight = 0;             ///< sum: information of the offset of the centre [1/m^2]
  double turn = 0;               ///< information of the turn about the centre [1/rad^2]
  bool turn_known = false;       ///< false: the points lie above one another; yaw is 0
  double cost = 0;               ///< weighted sum of squares that is left
  /// How Rz(yaw) (p_B - centre) changes with the yaw.
  Vec3 swing(const Vec3& p_B) const;
};
/// In closed form. Without points: the identity, weight 0.
LevelFit fitLevel(const std::vector<LevelPair>& pairs);

}  // namespace geometry
}  // namespace vir
