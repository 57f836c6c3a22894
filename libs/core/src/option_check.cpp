#include "vir/core/option_check.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ini_text.h"
#include "vir/core/ini_writer.h"

namespace vir {
inline namespace core {

void refuseSetting(const std::string& section, const std::string& key, const std::string& value,
                   const std::string& problem) {
  throw std::invalid_argument("[" + section + "] " + key + " = " + ini::shown(value) + ": " +
                              problem);
}

void OptionCheck::value(const char* key, int& v, Bounds<int> bounds, const char*) {
  if (v >= bounds.min && v <= bounds.max) return;
  refuseSetting(section_, key, std::to_string(v),
                "out of bounds; allowed: " + ini::allowedText(bounds));
}

void OptionCheck::value(const char* key, double& v, Bounds<double> bounds, const char*) {
  if (v >= bounds.min && v <= bounds.max) return;
  refuseSetting(section_, key, numberText(v),
                "out of bounds; allowed: " + ini::allowedText(bounds));
}

void OptionCheck::value(const char* key, std::vector<double>& v, std::size_t size, const char*) {
  std::string text;
  for (const double x : v) text += (text.empty() ? "" : " ") + numberText(x);
  const bool finite = std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
  if (finite && (size == 0 || v.size() == size)) return;
  refuseSetting(section_, key, text,
                (finite ? std::to_string(v.size()) + " numbers" : "not finite") +
                    std::string("; allowed: ") + ini::allowedListText(size));
}

void OptionCheck::choice(const char* key, std::string& v, const std::vector<std::string>& allowed,
                         const char*) {
  if (std::find(allowed.begin(), allowed.end(), v) != allowed.end()) return;
  refuseSetting(section_, key, v, "not one of the choices; allowed: " + ini::joined(allowed));
}

}  // namespace core
}  // namespace vir
