#pragma once
/// Why the paths of two robots leave the transform between their worlds open.
#include <string>
#include <vector>

#include "vir/team/world_transform.h"

namespace vir::team {

struct GeometryProblem {
  std::string reason;     ///< and what would help; empty if there is no such reason
  bool mirrored = false;  ///< two solutions remain however many ranges come
};

/// `anchor`: one that is used, else nullptr. `ranges` must not be empty.
GeometryProblem geometryProblem(const std::vector<MutualRange>& ranges, const SharedAnchor* anchor);

}  // namespace vir::team
