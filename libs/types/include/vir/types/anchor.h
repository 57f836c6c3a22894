#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "vir/geometry/so3.h"

namespace vir {
inline namespace types {

enum class AnchorState {
  collecting,   ///< no position yet; `Anchor::advice` says what is missing
  mirror_open,  ///< a second position explains the ranges as well
  estimated,
  fixed,
  moved,  ///< its ranges contradict it: being found anew
};
/// As written in anchors.csv.
const char* name(AnchorState state);
/// False, and nothing done, for a word that is none of these.
bool parse(const std::string& word, AnchorState* state);

/// The robot has just put down this anchor.
struct DeployedAnchor {
  std::uint64_t id = 0;
  Vec3 p_B = Vec3::Zero();  ///< in the body at that time [m]
  double sigma_m = 0.2;
};

/// An anchor as now known, in W.
struct Anchor {
  std::uint64_t id = 0;
  bool has_position = false;
  Vec3 p_W = Vec3::Zero();         ///< [m]
  Mat3 covariance = Mat3::Zero();  ///< [m^2]; spans both positions while `mirror_open`
  double bias_m = 0;               ///< constant part of its ranges that is no distance
  double bias_sigma_m = 0;
  AnchorState state = AnchorState::collecting;
  std::string advice;              ///< e.g. "move sideways: the path so far is a straight line"
  Vec3 mirror_p_W = Vec3::Zero();  ///< the other position while `mirror_open`
  /// Where to go next so that its ranges tell most; none: nothing nearby would help much [m].
  std::optional<Vec3> waypoint_W;
  long ranges_used = 0, ranges_rejected = 0;
};

}  // namespace types
}  // namespace vir
