#pragma once
#include <optional>
#include <vector>

#include "vir/team/find_transform.h"

namespace vir::team {

/// Mutual ranges with both robots' states in, the transform between their worlds out. One object
/// per pair of robots, A and B.
class PairSolver {
 public:
  virtual ~PairSolver() = default;
  /// In order of time. Segments count up when a robot's estimator starts anew: another world.
  virtual void add(const MutualRange& range, int segment_A, int segment_B) = 0;
  /// All anchors that both robots know, as believed now; replaces what was set before.
  virtual void setAnchors(const std::vector<SharedAnchor>& anchors) = 0;
  /// What both robots' images show, as known now; replaces what was set before. A solver that knows
  /// ranges only leaves it out.
  virtual void setPlaces(const std::optional<SharedPlaces>& /*places*/) {}
  /// A's poses go on in another frame, to which `T_new_A` takes all that was added: no new world.
  virtual void moveA(const WorldTransform& T_new_A) = 0;
  /// p_A = T p_B from all that was added, valid at the newest range.
  virtual TransformAnswer answer() = 0;
};

}  // namespace vir::team
