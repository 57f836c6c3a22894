#include "text_scanner.h"

#include "vir/core/parse_number.h"

namespace vir {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }

int hexValue(char c) {
  if (isDigit(c)) return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

bool TextScanner::literal(std::string_view text) {
  if (!peek(text)) return false;
  rest_.remove_prefix(text.size());
  return true;
}

bool TextScanner::oneOf(std::string_view characters, char* which) {
  if (rest_.empty() || characters.find(rest_.front()) == characters.npos) return false;
  *which = rest_.front();
  rest_.remove_prefix(1);
  return true;
}

void TextScanner::blanks() {
  while (!rest_.empty() && (rest_.front() == ' ' || rest_.front() == '\t')) rest_.remove_prefix(1);
}

std::size_t TextScanner::digitsAt(std::size_t from) const {
  std::size_t n = 0;
  while (from + n < rest_.size() && isDigit(rest_[from + n])) ++n;
  return n;
}

bool TextScanner::integer(std::int64_t* value) {
  const std::size_t sign = peek("-") ? 1 : 0;
  const std::size_t digits = digitsAt(sign);
  if (digits == 0 || digits > 18) return false;
  parseNumber(rest_.substr(0, sign + digits), value);
  rest_.remove_prefix(sign + digits);
  return true;
}

bool TextScanner::hex(std::size_t least, std::size_t most, std::int64_t* value) {
  std::size_t n = 0;
  *value = 0;
  while (n < rest_.size() && hexValue(rest_[n]) >= 0) {
    if (n == most) return false;
    *value = *value * 16 + hexValue(rest_[n++]);
  }
  if (n < least) return false;
  rest_.remove_prefix(n);
  return true;
}

bool TextScanner::take(std::size_t size, double* value) {
  if (!parseFinite(rest_.substr(0, size), value)) return false;
  rest_.remove_prefix(size);
  return true;
}

bool TextScanner::fixed(std::size_t digits, double* value) {
  const std::size_t sign = peek("-") ? 1 : 0;
  const std::size_t whole = digitsAt(sign);
  const std::size_t point = sign + whole;
  if (whole == 0 || whole > 15 || point >= rest_.size() || rest_[point] != '.') return false;
  const std::size_t part = digitsAt(point + 1);
  if (part == 0 || part > 15 || (digits != 0 && part != digits)) return false;
  return take(point + 1 + part, value);
}

bool TextScanner::number(double* value) {
  std::size_t at = peek("-") ? 1 : 0;
  const std::size_t whole = digitsAt(at);
  if (whole == 0 || whole > 30) return false;
  at += whole;
  if (at < rest_.size() && rest_[at] == '.') {
    const std::size_t part = digitsAt(at + 1);
    if (part > 30) return false;
    at += 1 + part;
  }
  if (at < rest_.size() && (rest_[at] == 'e' || rest_[at] == 'E')) {
    std::size_t exponent = at + 1;
    if (exponent < rest_.size() && (rest_[exponent] == '-' || rest_[exponent] == '+')) ++exponent;
    const std::size_t digits = digitsAt(exponent);
    if (digits == 0 || digits > 3) return false;
    at = exponent + digits;
  }
  return take(at, value);
}

}  // namespace vir
