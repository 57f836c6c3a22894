#include "vir/tables/anchor_names.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "vir/core/parse_number.h"

namespace vir::tables {
namespace {

constexpr std::int32_t kFirst = 1'000'000;
constexpr std::size_t kLongest = 64, kMostNames = 100'000;

/// Bytes that go on a character which began with `lead`; -1 for what begins none.
int followersOf(unsigned char lead) {
  if (lead < 0x80) return 0;
  if (lead >= 0xc2 && lead < 0xe0) return 1;
  if (lead >= 0xe0 && lead < 0xf0) return 2;
  return lead >= 0xf0 && lead < 0xf5 ? 3 : -1;
}

bool isUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (int more = followersOf(static_cast<unsigned char>(text[i])); more != 0; --more) {
      if (more < 0 || ++i == text.size()) return false;
      if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return false;
    }
  }
  return true;
}

/// What separates, quotes or ends a field or a setting stands in no name.
bool isName(std::string_view text) {
  if (text.empty() || text.size() > kLongest || text.front() == ' ' || text.back() == ' ') {
    return false;
  }
  const bool letters = std::any_of(
      text.begin(), text.end(), [](unsigned char c) { return c >= 0x80 || std::isalpha(c) != 0; });
  // Two numbers are two columns run together.
  if (!letters && text.find(' ') != text.npos) return false;
  return std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return c >= 0x80 || std::isalnum(c) != 0 ||
           std::string_view(" _-:./#+()").find(char(c)) != std::string_view::npos;
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

std::string utf8Name(std::string_view text) {
  if (isUtf8(text)) return std::string(text);
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      out += c;
    } else {
      out += static_cast<char>(0xc0 | (byte >> 6));
      out += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return out;
}

std::string shownName(std::string_view name) {
  std::string out = utf8Name(name);
  std::size_t end = std::min(out.size(), kLongest);
  while (end > 0 && end < out.size() && (static_cast<unsigned char>(out[end]) & 0xc0) == 0x80)
    --end;
  out.resize(end);
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return out;
}

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
  const std::string text = utf8Name(name);
  if (!isName(text)) return false;
  if (isOtherNumber(text)) return false;
  if (asNumber(text, number) && isFree(*number)) return true;
  const auto known = mapped_.find(text);
  if (known == mapped_.end() && mapped_.size() >= kMostNames) return false;
  *number = ownNumber(text);
  return true;
}

std::string AnchorNames::remarks() const {
  std::string text;
  for (const auto& [name, number] : mapped_) {
    text += "// anchor " + std::to_string(number) + " is '" + shownName(name) + "'\n";
  }
  return text;
}

}  // namespace vir::tables
