#include "stamp_jitter.h"

#include <cmath>
#include <vector>

#include "vir/core/order_statistics.h"

namespace vir::estimator {
namespace {

constexpr std::size_t kImages = 60, kFewest = 20;
/// Standard deviations per median distance from the median.
constexpr double kPerMedian = 1.4826;
/// Stamps that are right seem to scatter by up to 1 ms, by noise and the window's own errors [s].
constexpr double kLeastS = 0.0025;

}  // namespace

void StampJitter::add(double late_s) {
  if (!std::isfinite(late_s)) return;
  late_.push_back(late_s);
  if (late_.size() > kImages) late_.pop_front();
  if (late_.size() < kFewest) return;
  std::vector<double> values(late_.begin(), late_.end());
  const double middle = medianInPlace(&values);
  for (double& v : values) v = std::abs(v - middle);
  const double sigma = kPerMedian * medianInPlace(&values);
  sigma_ = sigma > kLeastS ? sigma : 0;
}

}  // namespace vir::estimator
