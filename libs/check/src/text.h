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

}  // namespace vir::check
