#pragma once
/// Times that files and peers claim: any 64 bits.
#include "vir/core/time.h"

namespace vir {
inline namespace core {

/// The year 2100 on a clock that counts from 1970.
constexpr TimeNs kLatestStamp = 4'102'444'800'000'000'000;

/// Can a sensor's clock show this? One that counts from its start begins at 0. What has no stamp at
/// all is centuries before that on MRPT's clock.
constexpr bool isStamp(TimeNs t) { return t >= 0 && t < kLatestStamp; }

/// a - b, or the nearest that 64 bits hold. Of stamps (isStamp) any difference fits.
inline TimeNs timeBetween(TimeNs b, TimeNs a) {
  TimeNs out = 0;
  if (!__builtin_sub_overflow(a, b, &out)) return out;
  return a > b ? INT64_MAX : INT64_MIN;
}

}  // namespace core
}  // namespace vir
