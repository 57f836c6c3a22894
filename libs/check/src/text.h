#pragma once
#include <cstdio>
#include <string>

namespace vir::check {

/// `v` with `digits` significant digits.
inline std::string num(double v, int digits = 3) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*g", digits, v);
  return text;
}

// With kDriver of finding.h.
inline constexpr const char* kDegreesRemedy =
    "import with --set DRIVER.gyro_unit=deg/s, or multiply it by 0.0174533";

inline constexpr const char* kMillidegreesRemedy =
    "mdeg/s: import with --set DRIVER.gyro_unit=mdeg/s, or multiply it by 1.74533e-5; counts: "
    "multiply them by the range over the resolution";

}  // namespace vir::check
