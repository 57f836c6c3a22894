#pragma once
/// Numbers as JSON arrays, with as many decimals as they are worth: nlohmann writes 17 digits.
#include <cmath>
#include <functional>
#include <string>

#include "csv_text.h"

namespace vir::results {

/// null for what is not a number; no zeros at the end.
inline std::string jsonNumber(double v, int decimals) {
  if (!std::isfinite(v) || std::abs(v) > 1e12) return "null";
  std::string text = csv::format("%.*f", decimals, v);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

/// "name":[...] with a comma in front unless `out` has just begun.
inline void addColumn(const char* name, std::size_t count, int decimals,
                      const std::function<double(std::size_t)>& value, std::string* out) {
  if (out->back() != '{') *out += ',';
  *out += std::string("\"") + name + "\":[";
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) *out += ',';
    *out += jsonNumber(value(i), decimals);
  }
  *out += ']';
}

}  // namespace vir::results
