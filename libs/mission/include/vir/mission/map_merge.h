#pragma once
#include "vir/mission/loop_closer.h"
#include "vir/mission/mission_map.h"

namespace vir::mission {

struct MergedMaps {
  MissionMap map;  ///< in the frame of the first
  LoopCounts loops;
  long known = 0;  ///< keyframes of the second that the first has already: they are not taken again
};

/// Both in the frame of the first, whose keyframes stay where they are; the second's path is
/// corrected where the two have seen the same. What both hold of one image is taken once; a second
/// that holds nothing else leaves the first as it is. Throws std::runtime_error if they are of
/// different cameras, or no place of the one is found in the other.
MergedMaps merge(const MissionMap& first, const MissionMap& second, const LoopOptions& options);

}  // namespace vir::mission
