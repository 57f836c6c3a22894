#pragma once
/// The transform between two robots' worlds. Both have z up (gravity is common), so a yaw and an
/// offset remain: p_A = Rz(yaw) p_B + t (section "Distributed Collaborative SLAM").
#include <Eigen/Core>
#include <cstdint>

#include "vir/core/time.h"
#include "vir/geometry/level_transform.h"
#include "vir/geometry/pose.h"
#include "vir/types/shared_places.h"

namespace vir::team {

/// Takes B's world to A's.
using WorldTransform = LevelTransform;

/// Angle in (-pi, pi].
double wrapAngle(double angle_rad);

/// A range between two robots, and where each one's antenna was at its time in its own world.
struct MutualRange {
  TimeNs t = 0;
  double range_m = 0;
  double sigma_m = 0.1;  ///< of the range alone
  Vec3 p_A = Vec3::Zero(), p_B = Vec3::Zero();
  Mat3 cov_A = Mat3::Zero(), cov_B = Mat3::Zero();  ///< of the positions [m^2]; zero: exact
};

/// An anchor that both robots know, each in its own world, as last estimated.
struct SharedAnchor {
  std::uint64_t id = 0;
  Vec3 p_A = Vec3::Zero(), p_B = Vec3::Zero();
  Mat3 cov_A = Mat3::Zero(), cov_B = Mat3::Zero();  ///< [m^2]
};

}  // namespace vir::team
