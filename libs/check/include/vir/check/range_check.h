#pragma once
/// Units and plausibility of ranges.
#include <map>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/types/range.h"

namespace vir::check {

/// Memory does not grow with the recording.
class RangeCheck {
 public:
  explicit RangeCheck(std::string label) : label_(std::move(label)) {}
  void add(const Range& range);
  std::vector<Finding> findings() const;

 private:
  struct Anchor {
    std::vector<double> values, speeds, bends;  ///< the first ones
    double last = 0, before = 0;
    TimeNs last_t = 0;
    long count = 0, whole = 0, stuck = 0;
  };
  void checkUnit(std::vector<Finding>* out) const;

  std::string label_;
  std::map<std::uint64_t, Anchor> anchors_;
  long count_ = 0, not_positive_ = 0, other_anchors_ = 0;
  double sigma_m_ = 0;
};

}  // namespace vir::check
