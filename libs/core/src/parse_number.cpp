#include "vir/core/parse_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "vir/core/text.h"

namespace vir {
inline namespace core {
namespace {

/// Of a number that no double holds: is it below 1? By the place of its first digit that is not 0
/// and its exponent.
bool isTiny(std::string_view number) {
  const std::size_t e = std::min(number.find_first_of("eE"), number.size());
  const std::string_view digits = number.substr(0, e);
  const std::size_t point = std::min(digits.find('.'), digits.size());
  const std::size_t first = std::min(digits.find_first_of("123456789"), digits.size());
  const double place = static_cast<double>(point) - static_cast<double>(first);
  // An exponent too long for an integer is larger than whatever the place is.
  std::string_view exponent = number.substr(std::min(e + 1, number.size()));
  const bool negative = exponent.substr(0, 1) == "-";
  if (!exponent.empty() && (negative || exponent.front() == '+')) exponent.remove_prefix(1);
  long size = 0;
  if (!exponent.empty() && !parseNumber(exponent, &size)) return negative;
  return place + static_cast<double>(negative ? -size : size) <= 0;
}

}  // namespace

bool parseNumber(std::string_view text, double* value) {
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
    if (!text.empty() && text.front() == '-') return false;
  }
  double parsed = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, parsed);
  if (end != last || error == std::errc::invalid_argument) return false;
  if (error == std::errc::result_out_of_range) {
    const double size = isTiny(text) ? 0 : std::numeric_limits<double>::infinity();
    parsed = text.front() == '-' ? -size : size;
  }
  *value = parsed;
  return true;
}

bool parseFinite(std::string_view text, double* value) {
  double parsed = 0;
  if (!parseNumber(text, &parsed) || !std::isfinite(parsed)) return false;
  *value = parsed;
  return true;
}

bool parseBool(std::string_view text, bool* value) {
  const std::string word = lowerCase(std::string(text));
  const bool yes = word == "true" || word == "yes" || word == "1";
  if (!yes && word != "false" && word != "no" && word != "0") return false;
  *value = yes;
  return true;
}

}  // namespace core
}  // namespace vir
