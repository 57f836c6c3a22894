#pragma once
#include <string>
#include <vector>

#include "vir/team/merged_map.h"
#include "vir/team/pair_transform.h"

namespace vir::results {

/// transforms.json; the layout is in docs/rendezvous.md.
std::string transformsJson(const std::vector<team::PairTransform>& pairs,
                           const team::MergedMap& map);

}  // namespace vir::results
