#pragma once
/// Where to start the refinement from: every transform that might be the right one.
#include <vector>

#include "evidence_cost.h"

namespace vir::team {

/// About `most` of the ranges, evenly spread, first and last included.
std::vector<MutualRange> thinned(const std::vector<MutualRange>& ranges, int most);

/// By way of the anchors: the closed form's two yaws per range, and where there are more than a few
/// ranges the minima of the cost over the yaw.
std::vector<Vec4> startsThroughAnchors(const EvidenceCost& cost);

/// From ranges alone: with the yaw given, the offset follows by trilateration (Trawny et al. 2010:
/// squared ranges are linear in the offset and its square); minima over the yaw.
std::vector<Vec4> startsFromRanges(const EvidenceCost& cost);

/// DIRECT (NLopt) over the yaw and the direction from A to B at one range, whose length is taken as
/// it is; the best point of every sector of the yaw. Evaluations are counted, not timed.
std::vector<Vec4> startsFromGlobalSearch(const EvidenceCost& cost, int evaluations);

}  // namespace vir::team
