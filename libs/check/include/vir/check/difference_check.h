#pragma once
/// Units and plausibility of differences of ranges (TDoA).
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "vir/check/finding.h"
#include "vir/check/range_path.h"
#include "vir/types/range.h"

namespace vir::check {

/// Memory does not grow with the recording.
class DifferenceCheck {
 public:
  void add(const Range& difference);
  /// `places`: where anchors are, as far as somebody says so. No difference is larger than the two
  /// are apart.
  std::vector<Finding> findings(const GivenAnchors& places) const;

 private:
  struct Pair {
    std::vector<double> values;  ///< the first ones [m]
    double last = 0;
    long count = 0, stuck = 0;
  };
  void checkPlaces(const GivenAnchors& places, std::vector<Finding>* out) const;

  std::map<std::pair<std::uint64_t, std::uint64_t>, Pair> pairs_;  ///< reference, anchor
  long count_ = 0, none_ = 0, other_pairs_ = 0;
  double sigma_m_ = 0;
};

}  // namespace vir::check
