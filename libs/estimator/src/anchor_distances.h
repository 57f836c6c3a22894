#pragma once
/// Internal: ranges that anchors have measured to one another.
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "vir/types/anchor_range.h"

namespace vir::estimator {

/// Anchors stand still: what they measure again and again is one number for each pair.
class AnchorDistances {
 public:
  using Pair = std::pair<std::uint64_t, std::uint64_t>;  ///< ids, the smaller one first
  struct Distance {
    double range_m = 0;  ///< median of the newest
    double sigma_m = 0;  ///< of that, by scatter and claim; without what all have in common
  };

  /// False for what cannot be. `sigma_m`: where the range does not say.
  bool add(const AnchorRange& range, double sigma_m, double max_range_m);
  /// The anchor was moved: what it has measured is of the past.
  void forget(std::uint64_t id);
  /// Empty for a pair that has measured too little.
  std::optional<Distance> of(const Pair& pair) const;
  std::vector<Pair> pairs() const;

 private:
  struct Seen {
    std::vector<double> newest;  ///< a ring
    std::size_t next = 0;
    double sigma_m = 0;
  };
  std::map<Pair, Seen> seen_;
};

}  // namespace vir::estimator
