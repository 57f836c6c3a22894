#pragma once
/// What a robot knows of another one that it ranges to.
#include <optional>

#include "vir/team/pair_transform.h"
#include "vir/team/robot_record.h"

namespace vir::team {

struct PeerResult {
  int id = 0;               ///< the other robot's, as a beacon
  PairTransform transform;  ///< p_own = T p_other, from what came over the air
  long ranges = 0;          ///< measured to it
  /// Not used: no broadcast of the other robot's position with the range; no own pose at its time.
  long without_broadcast = 0, without_pose = 0;
  long doubled = 0;               ///< told by both robots: used once
  std::optional<KnownPose> told;  ///< its newest pose, in its own world; empty: it tells none
};

/// Where it was when it last told its pose, in this robot's world; empty as long as the transform
/// is not unique. Its own attitude is taken as exact but for what the transform adds.
std::optional<KnownPose> poseInOwnWorld(const PeerResult& peer);

}  // namespace vir::team
