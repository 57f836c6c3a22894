#pragma once
/// Places that two robots' images have in common.
#include <Eigen/Core>

#include "vir/core/time.h"
#include "vir/geometry/level_transform.h"

namespace vir {
inline namespace types {

/// How the world of one robot, B, lies in that of another, A, by places that both have seen.
struct SharedPlaces {
  LevelTransform T_A_B;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of (yaw, x, y, z) [rad, m]
  Vec3 centre_B = Vec3::Zero();                          ///< mean of the places, in B's world [m]
  int places = 0;  ///< of B's path, apart from one another; 0: none in common
  int images = 0;  ///< of B that were found in A's map, all places together
  /// When the later of the two robots had seen the first of them, and the last.
  TimeNs since = 0, until = 0;
  int segment_A = 0, segment_B = 0;  ///< of the worlds, as of `StateEstimate`
};

}  // namespace types
}  // namespace vir
