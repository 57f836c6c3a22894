#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "vir/window/long_window.h"

namespace vir::window {
namespace {

/// What is measured: a range to an anchor, or the difference of two.
using Measured = std::pair<std::uint64_t, std::optional<std::uint64_t>>;
Measured measuredBy(const HeldRange& r) { return {r.anchor, r.reference}; }

/// Averages each of these ranges with the next one of them; how many are left.
std::size_t halve(std::vector<HeldRange>* ranges, const Measured& which) {
  std::vector<HeldRange> kept;
  HeldRange* open = nullptr;  // one of them, waiting for a partner
  std::size_t left = 0;
  kept.reserve(ranges->size());
  for (const HeldRange& r : *ranges) {
    if (measuredBy(r) != which) {
      kept.push_back(r);
      continue;
    }
    if (!open) {
      kept.push_back(r);
      open = &kept.back();
      ++left;
      continue;
    }
    const double a = open->merged, b = r.merged, sum = a + b;
    const double single = std::max(open->sigma_m * std::sqrt(std::min(a, 16.0)),
                                   r.sigma_m * std::sqrt(std::min(b, 16.0)));
    open->t += static_cast<TimeNs>(static_cast<double>(r.t - open->t) * b / sum);
    open->range_m = (a * open->range_m + b * r.range_m) / sum;
    open->motion = (a * open->motion + b * r.motion) / sum;
    open->lever = (a * open->lever + b * r.lever) / sum;
    open->merged += r.merged;
    open->sigma_m = single / std::sqrt(std::min(sum, 16.0));
    open = nullptr;
  }
  *ranges = std::move(kept);
  return left;
}

}  // namespace

void mergeRanges(std::vector<HeldRange>* ranges, std::size_t limit) {
  std::map<Measured, std::size_t> count;
  for (const HeldRange& r : *ranges) ++count[measuredBy(r)];
  for (auto& [which, n] : count) {
    while (n > std::max<std::size_t>(limit, 1)) n = halve(ranges, which);
  }
}

}  // namespace vir::window
