#pragma once
/// MRPT's clock counts 100 ns since 1601; ours 1 ns since 1970. Integer arithmetic only: by way of
/// a double a Unix stamp is off by up to 300 ns.
#include <mrpt/core/Clock.h>

#include "vir/core/time.h"

namespace vir::rawlog {

/// 1970-01-01 on MRPT's clock [100 ns].
constexpr std::int64_t kUnixEpochTicks = 116444736000000000LL;

/// What is below 100 ns is cut off (towards the past).
inline mrpt::Clock::time_point toMrptTime(TimeNs t) {
  const std::int64_t ticks = t / 100 - (t % 100 < 0 ? 1 : 0);
  return mrpt::Clock::time_point(mrpt::Clock::duration(ticks + kUnixEpochTicks));
}

/// Exact; stamps that nanoseconds cannot hold (before 1678, after 2261) saturate.
inline TimeNs fromMrptTime(const mrpt::Clock::time_point& t) {
  constexpr std::int64_t limit = INT64_MAX / 100;
  const std::int64_t count = t.time_since_epoch().count();
  if (count > limit + kUnixEpochTicks) return limit * 100;
  if (count < -limit + kUnixEpochTicks) return -limit * 100;
  return (count - kUnixEpochTicks) * 100;
}

}  // namespace vir::rawlog
