#pragma once
/// Time in integer nanoseconds on the IMU clock.
#include <cstdint>

namespace vir {
inline namespace core {

/// Nanoseconds since the epoch of the recording's clock (Unix time for EuRoC).
using TimeNs = std::int64_t;

/// Difference or stamp in seconds. Take the difference in integers first: a Unix stamp in a double
/// has a resolution of 0.2 microseconds only.
constexpr double toSeconds(TimeNs ns) { return static_cast<double>(ns) * 1e-9; }

/// Seconds to nanoseconds, rounded to the nearest.
constexpr TimeNs fromSeconds(double s) {
  return static_cast<TimeNs>(s * 1e9 + (s >= 0 ? 0.5 : -0.5));
}

}  // namespace core
}  // namespace vir
