#pragma once
/// Internal: what is known of one anchor besides its state in the window.
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "vir/ranging/anchor_initialization.h"
#include "vir/ranging/range_gate.h"

namespace vir::estimator {

enum class AnchorPhase { collecting, mirror_open, estimated };

struct AnchorTrack {
  std::uint64_t id = 0;
  int generation = 0;   ///< counts up when the anchor is found to be elsewhere
  int generations = 0;  ///< the highest so far
  AnchorPhase phase = AnchorPhase::collecting;
  bool moved = false;  ///< it has been found elsewhere and has no new position yet
  std::string advice = "too few ranges";
  std::optional<ranging::AnchorPrior> prior;
  Vec3 mirror_p_W = Vec3::Zero();
  ranging::RangeGate gate;
  std::size_t tried_with = 0;  ///< ranges at the last attempt to find it
  long used = 0, rejected = 0, collected = 0;
  TimeNs found_at = 0;
  /// Until the anchor has settled: what a fresh search says of (position, bias) [m^2]. The window's
  /// covariance, taken where the search landed, is too sure of itself on a ring or between mirror
  /// images.
  Eigen::Matrix4d search_covariance = Eigen::Matrix4d::Zero();
  bool settled = false;
  bool well_known = false;  ///< a fresh search has once found it well determined where it is
  /// What it was before its ranges contradicted it, and what speaks for that again since (log of
  /// the likelihood ratio to what it is now, never below 0).
  std::shared_ptr<const AnchorTrack> former;
  double former_evidence = 0;
  int next_search = 0;         ///< keyframes until the next fresh search
  bool mirror_closed = false;  ///< the mirror image has been ruled out for good
  int next_check = 0;          ///< keyframes until the mirror image is looked at again

  /// Name of this generation in the window: an anchor that was moved is another one there.
  std::uint64_t key() const { return id | (static_cast<std::uint64_t>(generation) << 48); }
  bool known() const { return phase != AnchorPhase::collecting; }
};

}  // namespace vir::estimator
