#pragma once
/// Internal: anchors that two runs have found, in the frame of one map.
#include <vector>

#include "vir/core/log.h"
#include "vir/types/anchor.h"

namespace vir::mission {

/// `before`: of the map; `now`: of a run in it, both in M; ordered by id. An anchor of both is
/// known at least as well as by the better of the two, whatever errors they share, as of a wall
/// beside it: no anchor becomes certain by being found often. Where the two contradict (0.1 % of
/// right ones do), the map's stays and a warning says so.
std::vector<Anchor> joinAnchors(const std::vector<Anchor>& before, const std::vector<Anchor>& now,
                                const LogSink& log);

}  // namespace vir::mission
