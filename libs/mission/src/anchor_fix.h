#pragma once
/// Internal: where the estimator's world lies in a map, by anchors that both know.
#include <optional>
#include <vector>

#include "level_algebra.h"
#include "vir/types/anchor.h"

namespace vir::mission {

/// T_M_W from two anchors or more that lie apart horizontally; its covariance is of (offset in M
/// [m], turn [rad]). Nothing where they are fewer, or do not fit on one another: one has been
/// moved, or another has its id.
std::optional<LevelGuess> fixByAnchors(const std::vector<Anchor>& in_M,
                                       const std::vector<Anchor>& in_W);

/// Has it a position that nothing else explains as well?
bool isKnown(const Anchor& anchor);
/// Whether two that are known can be the same anchor, both in M (0.1 % that are do not fit).
bool fits(const Anchor& a, const Anchor& b);

/// How far the anchors that both know are from one another if T_M_W is right: chi-square of so many
/// degrees of freedom.
struct AnchorFit {
  double chi2 = 0;
  int dof = 0;
};
AnchorFit anchorFit(const LevelGuess& T_M_W, const std::vector<Anchor>& in_M,
                    const std::vector<Anchor>& in_W);

}  // namespace vir::mission
