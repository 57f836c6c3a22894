#include "anchor_distances.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vir/core/order_statistics.h"

namespace vir::estimator {
namespace {

/// Of a pair that many are kept; with fewer nothing is said; errors at one place are alike: more
/// than so many do not make it better.
constexpr std::size_t kKept = 64, kFewest = 5, kMostWorth = 16;
/// A broken stream of ids must not fill the memory.
constexpr std::size_t kMostPairs = 4096;

}  // namespace

bool AnchorDistances::add(const AnchorRange& range, double sigma_m, double max_range_m) {
  const auto largest = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  const bool possible = range.first != range.second && range.first <= largest &&
                        range.second <= largest && range.range_m > 0 &&
                        range.range_m <= max_range_m && std::isfinite(range.sigma_m);
  if (!possible) return false;
  const Pair pair = std::minmax(range.first, range.second);
  if (seen_.size() >= kMostPairs && seen_.count(pair) == 0) return false;
  Seen& s = seen_[pair];
  s.sigma_m = range.sigma_m > 0 ? range.sigma_m : sigma_m;
  if (s.newest.size() < kKept) {
    s.newest.push_back(range.range_m);
  } else {
    s.newest[s.next++ % kKept] = range.range_m;
  }
  return true;
}

void AnchorDistances::forget(std::uint64_t id) {
  for (auto at = seen_.begin(); at != seen_.end();) {
    const bool its = at->first.first == id || at->first.second == id;
    at = its ? seen_.erase(at) : std::next(at);
  }
}

std::optional<AnchorDistances::Distance> AnchorDistances::of(const Pair& pair) const {
  const auto at = seen_.find(pair);
  if (at == seen_.end() || at->second.newest.size() < kFewest) return std::nullopt;
  const Seen& s = at->second;
  Distance out;
  out.range_m = median(s.newest);
  std::vector<double> off;
  for (const double r : s.newest) off.push_back(std::abs(r - out.range_m));
  const double scatter = std::max(s.sigma_m, 1.4826 * median(off));
  out.sigma_m = scatter / std::sqrt(static_cast<double>(std::min(s.newest.size(), kMostWorth)));
  return out;
}

std::vector<AnchorDistances::Pair> AnchorDistances::pairs() const {
  std::vector<Pair> out;
  for (const auto& [pair, s] : seen_) out.push_back(pair);
  return out;
}

}  // namespace vir::estimator
