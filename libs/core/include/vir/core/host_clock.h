#pragma once
#include <chrono>

#include "vir/core/time.h"

namespace vir {
inline namespace core {

/// The host's clock, ns since 1970. Never asked for by an estimator: the same input gives the same
/// result whenever it comes.
inline TimeNs hostNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

}  // namespace core
}  // namespace vir
