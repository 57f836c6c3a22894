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

inline constexpr const char* kDegreesRemedy =
    "import with --set euroc.gyro_unit=deg/s (csv.gyro_unit for tables), or multiply it by "
    "0.0174533";

}  // namespace vir::check
