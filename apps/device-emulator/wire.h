#pragma once
/// Little helpers of the encoders.
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "vir/core/little_endian.h"

namespace vir::emulator {

template <typename... Args>
std::string printed(const char* format, Args... args) {
  char text[512];
  const int n = std::snprintf(text, sizeof text, format, args...);
  return {text, static_cast<std::size_t>(n)};
}

inline long long rounded(double v) { return std::llround(v); }

inline void require(bool possible, const char* what) {
  if (!possible) throw std::invalid_argument(what);
}

}  // namespace vir::emulator
