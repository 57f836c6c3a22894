#pragma once
#include <optional>
#include <string>
#include <vector>

#include "vir/alignment/find_transform.h"
#include "vir/alignment/transform_graph.h"

namespace vir {

/// What became of a pair of robots.
struct PairTransform {
  std::string from, to;                  ///< p_to = T p_from
  TransformAnswer answer;                ///< the last one
  std::optional<double> first_unique_s;  ///< since the pair's first mutual range
  bool joint = false;                    ///< the first solution is from both recordings together
};

/// transforms.json; the layout is in docs/rendezvous.md.
std::string transformsJson(const std::vector<PairTransform>& pairs,
                           const std::vector<TransformLoop>& loops, const std::string& root);

}  // namespace vir
