#pragma once
#include <cstdint>
#include <optional>

#include "vir/core/time.h"
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

}  // namespace types
}  // namespace vir
