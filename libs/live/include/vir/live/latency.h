#pragma once
#include <array>
#include <cstddef>

namespace vir::live {

/// From the arrival of an image to its pose.
struct Latency {
  long count = 0;
  double median_ms = 0, p95_ms = 0, p99_ms = 0, max_ms = 0;
};

/// Latencies of a run of any length, in memory that does not grow with it.
class LatencyCounter {
 public:
  void add(double ms);
  /// The longest is exact, the others to 1 %.
  Latency summary() const;

 private:
  /// Each bin's end is 1 % above its beginning: 0.01 ms to 17 minutes.
  static constexpr std::size_t kBins = 1852;
  static std::size_t binOf(double ms);
  double quantile(double share) const;

  std::array<long, kBins> bins_{};
  long count_ = 0;
  double max_ms_ = 0;
};

}  // namespace vir::live
