#include "vir/tables/anchor_names.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "vir/core/parse_number.h"

namespace vir::tables {
namespace {

constexpr std::int32_t kFirst = 1'000'000;
constexpr std::size_t kLongest = 64, kMostNames = 100'000;

bool isName(std::string_view text) {
  return !text.empty() && text.size() <= kLongest &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_' || c == '-' || c == ':' || c == '.';
         });
}

/// Whole numbers in any decimal notation (`7`, `7.0`), and 0x84.
bool asNumber(std::string_view text, std::int32_t* number) {
  if (text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X')) {
    return parseNumber(text.substr(2), number, 16);
  }
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string_view part = text.substr(std::min(point + 1, text.size()));
  return part.find_first_not_of('0') == part.npos && parseNumber(text.substr(0, point), number);
}

/// `3.5`, `nan`: a number, but nobody's name.
bool isOtherNumber(std::string_view text) {
  double v = 0;
  return parseNumber(text, &v) && (!std::isfinite(v) || v != std::floor(v));
}

/// Stays what it is: not taken for names.
bool isFree(std::int32_t number) {
  return number < kFirst || number >= kFirst + static_cast<std::int32_t>(kMostNames);
}

}  // namespace

std::int32_t AnchorNames::ownNumber(std::string_view name) {
  const auto next = kFirst + static_cast<std::int32_t>(mapped_.size());
  return mapped_.emplace(name, next).first->second;
}

std::int32_t AnchorNames::numberOfAny(std::string_view name) {
  std::int32_t number = 0;
  if (asNumber(name, &number) && number >= 0 && isFree(number)) return number;
  return ownNumber(name);
}

bool AnchorNames::numberOf(std::string_view name, std::int32_t* number) {
  if (!isName(name)) return false;
  if (isOtherNumber(name)) return false;
  if (asNumber(name, number) && isFree(*number)) return true;
  const auto known = mapped_.find(std::string(name));
  if (known == mapped_.end() && mapped_.size() >= kMostNames) return false;
  *number = ownNumber(name);
  return true;
}

}  // namespace vir::tables
