#pragma once
/// Ranges that are wrong in proportion to the distance.
#include <vector>

#include "vir/check/range_fit.h"

namespace vir::check {

struct RangeScale {
  double error = 0;  ///< range = (1 + error) distance + bias
  double sigma = 0;
  long anchors = 0;  ///< that tell it
  bool found = false;
};

/// Of all anchors together, each with a place and bias of its own; with `held` at the places that
/// the fits have. Not found where they contradict each other, or where the error is too small or
/// too uncertain to speak of.
RangeScale commonScale(const std::vector<const AnchorFit*>& fits, bool held);

}  // namespace vir::check
