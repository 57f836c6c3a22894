#pragma once
#include <optional>
#include <string>

#include "vir/team/find_transform.h"

namespace vir::team {

/// What became of a pair of robots.
struct PairTransform {
  std::string from, to;                  ///< p_to = T p_from
  TransformAnswer answer;                ///< the last one
  std::optional<double> first_unique_s;  ///< since the pair's first mutual range
  bool joint = false;                    ///< the first solution is from both recordings together
};

}  // namespace vir::team
