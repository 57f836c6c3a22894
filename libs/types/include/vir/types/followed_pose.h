#pragma once
/// Keyframes as the odometry of an estimator followed them.
#include <Eigen/Core>

#include "vir/types/state.h"

namespace vir {
inline namespace types {

/// A keyframe in W, and in the world O of images and IMU alone, which ranges do not move: both have
/// z up.
struct FollowedPose : StampedPose {
  Pose T_O_B;
  double scale = 1;              ///< metres in W per metre in O, from here to the next
  Vec3 motion_O = Vec3::Zero();  ///< to the next, as both were seen together [m]
  /// Of the motion in O [m^2] and the turn about the vertical [rad^2] to the next; 0: neither is
  /// known.
  Eigen::Vector4d to_next = Eigen::Vector4d::Zero();
};

}  // namespace types
}  // namespace vir
