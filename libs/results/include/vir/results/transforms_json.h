#pragma once
#include <string>
#include <vector>

#include "vir/team/pair_transform.h"
#include "vir/team/transform_graph.h"

namespace vir::results {

/// transforms.json; the layout is in docs/rendezvous.md.
std::string transformsJson(const std::vector<team::PairTransform>& pairs,
                           const std::vector<team::TransformLoop>& loops, const std::string& root);

}  // namespace vir::results
