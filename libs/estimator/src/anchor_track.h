#pragma once
/// Internal: what is known of one anchor besides its state in the window.
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "vir/ranging/anchor_initialization.h"
#include "vir/ranging/next_waypoint.h"
#include "vir/ranging/range_gate.h"

namespace vir::estimator {

/// Its ranges are gathered until they say where it is.
struct Collecting {
  bool moved = false;          ///< it was known once, but is elsewhere now
  std::size_t tried_with = 0;  ///< ranges at the last attempt to find it
  std::vector<ranging::AnchorHypothesis> candidates = {};  ///< what that attempt took for possible
};

/// An anchor that has not settled is searched for again every few keyframes.
struct Youth {
  /// What a fresh search says of (position, bias) [m^2]. The window's covariance, taken where the
  /// search landed, is too sure of itself on a ring or between mirror images.
  Eigen::Matrix4d search_covariance = Eigen::Matrix4d::Zero();
  int next_search = 0;  ///< keyframes until the next fresh search
};

struct MirrorUnseen {};  ///< nobody has looked, or the two positions are one
struct MirrorOpen {
  Vec3 p_W = Vec3::Zero();  ///< fits its ranges about as well as where it is [m]
};
struct MirrorRuledOut {};  ///< for good

/// It has a position in the window.
struct Located {
  TimeNs found_at = 0;
  std::optional<Youth> youth;  ///< none: it has settled
  bool well_known = false;     ///< a fresh search has once found it well determined where it is
  std::variant<MirrorUnseen, MirrorOpen, MirrorRuledOut> mirror;
  int next_check = 0;       ///< keyframes until the mirror image is looked at again
  int next_bias_check = 0;  ///< keyframes until the bias is looked at again
  bool bias_due = false;    ///< it is to be looked at, best between two keyframes
  std::optional<ranging::AnchorInitialization> bias_search;  ///< what came of it
  bool bias_known = false;                                   ///< no more to be looked at

  const MirrorOpen* openMirror() const { return std::get_if<MirrorOpen>(&mirror); }
};

struct AnchorTrack {
  std::uint64_t id = 0;
  int generation = 0;   ///< counts up when the anchor is found to be elsewhere
  int generations = 0;  ///< the highest so far
  std::variant<Collecting, Located> state;
  std::string advice = "too few ranges";
  std::optional<ranging::AnchorPrior> prior;
  ranging::RangeGate gate;
  long used = 0, rejected = 0, collected = 0;
  /// What it was before its ranges contradicted it, and what speaks for that again since (log of
  /// the likelihood ratio to what it is now, never below 0).
  std::shared_ptr<const AnchorTrack> former;
  double former_evidence = 0;
  /// Its board turned out to be uncalibrated: its bias is as free as such a board's.
  bool uncalibrated = false;
  bool told_uncalibrated = false;  ///< somebody was told so

  /// The survey holds it in place; and it must not, since it was moved away from there.
  bool tied = false, left_survey = false;

  /// Name of this generation in the window: an anchor that was moved is another one there.
  std::uint64_t key() const { return id | (static_cast<std::uint64_t>(generation) << 48); }
  /// Under which ranges to it are held that were not believed: without a factor, as of an anchor
  /// that nobody knows, but a survey is judged by all of them.
  std::uint64_t doubtedKey() const { return id | (0x7fffull << 48); }
  Collecting* collecting() { return std::get_if<Collecting>(&state); }
  const Collecting* collecting() const { return std::get_if<Collecting>(&state); }
  /// nullptr while it has no position.
  Located* located() { return std::get_if<Located>(&state); }
  const Located* located() const { return std::get_if<Located>(&state); }
};

}  // namespace vir::estimator
