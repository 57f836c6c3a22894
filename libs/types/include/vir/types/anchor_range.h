#pragma once
#include <cstdint>

#include "vir/core/time.h"

namespace vir {
inline namespace types {

/// A range that an anchor has measured to another one.
struct AnchorRange {
  TimeNs t = 0;
  std::uint64_t first = 0, second = 0;
  double range_m = 0;
  double sigma_m = 0;  ///< <= 0: not known, the setting is used
};

}  // namespace types
}  // namespace vir
