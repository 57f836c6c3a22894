#include "vir/live/latency.h"

#include <algorithm>
#include <cmath>

namespace vir::live {
namespace {

constexpr double kLeastMs = 0.01, kWider = 1.01;

}  // namespace

std::size_t LatencyCounter::binOf(double ms) {
  if (!(ms > kLeastMs)) return 0;
  const double bin = std::log(ms / kLeastMs) / std::log(kWider);
  return bin < static_cast<double>(kBins - 1) ? static_cast<std::size_t>(bin) : kBins - 1;
}

void LatencyCounter::add(double ms) {
  ++bins_[binOf(ms)];
  ++count_;
  if (ms > max_ms_) max_ms_ = ms;
}

/// The middle of the bin that has it.
double LatencyCounter::quantile(double share) const {
  long left = static_cast<long>(share * static_cast<double>(count_ - 1));
  std::size_t bin = 0;
  while (bin + 1 < kBins && left >= bins_[bin]) left -= bins_[bin++];
  const double middle = kLeastMs * std::pow(kWider, static_cast<double>(bin) + 0.5);
  return std::min(middle, max_ms_);
}

Latency LatencyCounter::summary() const {
  Latency out;
  out.count = count_;
  if (count_ == 0) return out;
  out.median_ms = quantile(0.5);
  out.p95_ms = quantile(0.95);
  out.p99_ms = quantile(0.99);
  out.max_ms = max_ms_;
  return out;
}

}  // namespace vir::live
