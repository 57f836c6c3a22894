#pragma once
/// Which transform does the evidence speak for, if its covariances are as it says?
#include <cstddef>
#include <vector>

#include "mode_search.h"

namespace vir::team {

/// `offered`: ranges before those that cannot be used were left out.
TransformAnswer findAsSaid(const Evidence& evidence, std::size_t offered,
                           const std::vector<WorldTransform>& hints);

}  // namespace vir::team
