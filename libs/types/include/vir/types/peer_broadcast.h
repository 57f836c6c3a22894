#pragma once
#include <cstdint>
#include <optional>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"
#include "vir/geometry/so3.h"

namespace vir {
inline namespace types {

/// A position with its covariance in its sender's world.
struct SentPosition {
  TimeNs t = 0;
  Vec3 p_W = Vec3::Zero();         ///< [m]
  Mat3 covariance = Mat3::Zero();  ///< [m^2]
};

/// What another robot told: where its antenna is, or where it believes an anchor to be.
struct PeerBroadcast {
  int peer = 0;                         ///< who sent it
  std::optional<std::uint64_t> anchor;  ///< empty: the sender's antenna
  SentPosition sent;
};

/// Where another robot was by its own estimate, told at a rate of its own: it does not know when it
/// is ranged to.
struct PeerPose {
  int peer = 0;   ///< who sent it
  int world = 0;  ///< counts up with every new world of the sender: a new segment, a new start
  TimeNs t = 0;
  Pose T_W_B;                      ///< in that world
  Mat3 covariance = Mat3::Zero();  ///< of the position [m^2]
  Vec3 p_B_U = Vec3::Zero();       ///< its antenna in its body [m]
};

}  // namespace types
}  // namespace vir
