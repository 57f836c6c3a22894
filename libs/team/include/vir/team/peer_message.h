#pragma once
/// What a robot broadcasts when it is ranged to: where it is and where it believes an anchor to be,
/// both in its own world. 60 bytes, which fit a UWB packet; the layout is in docs/rendezvous.md.
#include <array>
#include <cstdint>
#include <optional>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"

namespace vir::team {

struct PeerAnchor {
  std::uint16_t id = 0;
  Vec3 p_W = Vec3::Zero();         ///< [m]
  Mat3 covariance = Mat3::Zero();  ///< [m^2]
};

struct PeerMessage {
  std::uint16_t robot = 0;    ///< who sends
  std::uint16_t segment = 0;  ///< of the sender's world; another one is another world
  std::uint16_t sequence = 0;
  TimeNs t = 0;                    ///< of the position, on the clock the robots share
  Vec3 p_W = Vec3::Zero();         ///< antenna in the sender's world [m]
  Mat3 covariance = Mat3::Zero();  ///< [m^2]
  std::optional<PeerAnchor> anchor;
};

constexpr std::size_t kPeerMessageBytes = 60;
using PeerPacket = std::array<std::uint8_t, kPeerMessageBytes>;

/// Positions are kept to 0.1 mm up to 200 km, standard deviations to 5 % (never smaller than given)
/// from 0.1 mm to 75 m, correlations to 0.01. Throws std::invalid_argument for what is not finite
/// or farther than that, or for a variance below 0.
PeerPacket encode(const PeerMessage& message);

enum class PeerDecoding { ok, wrong_size, not_ours, unknown_version, bad_checksum, bad_content };
/// "ok", "wrong_size", ...
const char* name(PeerDecoding decoding);

/// Any bytes. `message` is written only if all is well: then its numbers are finite and its
/// covariances positive semidefinite.
PeerDecoding decode(const std::uint8_t* bytes, std::size_t size, PeerMessage* message);

}  // namespace vir::team
