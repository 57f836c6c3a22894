#include "dates.h"

#include <algorithm>

#include "vir/core/parse_number.h"

namespace vir::tables {
namespace {

constexpr long kDay = 86'400;

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// Takes what stands in front of a text.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}

  /// A number of `least` to `most` digits.
  bool number(std::size_t least, std::size_t most, int* out) {
    std::size_t n = 0;
    while (n < rest_.size() && n < most && isDigit(rest_[n])) ++n;
    if (n < least || !parseNumber(rest_.substr(0, n), out)) return false;
    rest_.remove_prefix(n);
    return true;
  }
  std::string_view digits() {
    std::size_t n = 0;
    while (n < rest_.size() && isDigit(rest_[n])) ++n;
    const std::string_view out = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return out;
  }
  /// One of these, which is returned; 0: none.
  char oneOf(std::string_view characters) {
    if (rest_.empty() || characters.find(rest_.front()) == characters.npos) return 0;
    const char c = rest_.front();
    rest_.remove_prefix(1);
    return c;
  }
  bool literal(std::string_view text) {
    if (rest_.substr(0, text.size()) != text) return false;
    rest_.remove_prefix(text.size());
    return true;
  }
  bool skipAny(std::string_view characters) {
    const std::size_t n = std::min(rest_.find_first_not_of(characters), rest_.size());
    rest_.remove_prefix(n);
    return n > 0;
  }
  bool atEnd() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

/// Days since 1970 in the calendar of today (H. Hinnant, "chrono-compatible low-level date
/// algorithms"); false for a day that there is not.
bool daysOf(int year, int month, int day, long* days) {
  constexpr int kLengths[] = {31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  if (year < 1970 || year > 2261 || month < 1 || month > 12 || day < 1) return false;
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  if (day > kLengths[month - 1] - (month == 2 && !leap ? 1 : 0)) return false;
  const long y = month <= 2 ? year - 1 : year;
  const long era = y / 400, of_era = y - era * 400;
  const long of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  *days = era * 146'097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719'468;
  return true;
}

bool takeDate(Scanner* s, long* days) {
  const Scanner start = *s;
  int year = 0, month = 0, day = 0;
  if (s->number(4, 4, &year)) {
    const char between = s->oneOf("-/.");
    const std::size_t least = between == 0 ? 2 : 1;
    return s->number(least, 2, &month) && (between == 0 || s->oneOf({&between, 1}) != 0) &&
           s->number(least, 2, &day) && daysOf(year, month, day, days);
  }
  // Day first is told by its points; with slashes it may be the month.
  *s = start;
  return s->number(1, 2, &day) && s->literal(".") && s->number(1, 2, &month) && s->literal(".") &&
         s->number(4, 4, &year) && daysOf(year, month, day, days);
}

/// `seconds`: must be there.
bool takeTime(Scanner* s, bool seconds_needed, bool colons_needed, DateTime* out) {
  int hour = 0, minute = 0, second = 0;
  if (!s->number(1, 2, &hour)) return false;
  const bool colons = s->literal(":");
  if (!colons && colons_needed) return false;
  if (!s->number(2, 2, &minute)) return false;
  const bool has_seconds = colons ? s->literal(":") : true;
  if (has_seconds ? !s->number(2, 2, &second) : seconds_needed) return false;
  if (hour > 23 || minute > 59 || second > 60) return false;  // 60: a leap second
  out->seconds = hour * 3600L + minute * 60L + second;
  if (has_seconds && s->oneOf(".,") != 0) {
    out->fraction = s->digits();
    return !out->fraction.empty();
  }
  return true;
}

/// What is to be taken away for UTC [s].
bool takeOffset(Scanner* s, long* offset) {
  s->skipAny(" ");
  *offset = 0;
  if (s->atEnd() || s->literal("Z") || s->literal("z") || s->literal("UTC") || s->literal("GMT")) {
    return true;
  }
  const char sign = s->oneOf("+-");
  int hours = 0, minutes = 0;
  if (sign == 0 || !s->number(2, 2, &hours)) return false;
  const bool colon = s->literal(":");
  if ((colon || !s->atEnd()) && !s->number(2, 2, &minutes)) return false;
  *offset = (hours * 3600L + minutes * 60L) * (sign == '-' ? -1 : 1);
  return hours <= 15 && minutes <= 59;
}

}  // namespace

bool parseDateTime(std::string_view text, DateTime* out) {
  Scanner s(text);
  long days = 0, offset = 0;
  *out = {};
  if (!takeDate(&s, &days)) return false;
  const bool apart = s.oneOf("Tt_") != 0 || s.skipAny(" \t,;\"");
  if (!apart || !takeTime(&s, false, false, out) || !takeOffset(&s, &offset) || !s.atEnd()) {
    return false;
  }
  out->seconds += days * kDay - offset;
  return out->seconds >= 0;
}

bool isDate(std::string_view text) {
  Scanner s(text);
  long days = 0;
  // Eight digits alone may be any number.
  return text.find_first_of("-/.") != text.npos && takeDate(&s, &days) && s.atEnd();
}

bool parseTimeOfDay(std::string_view text, DateTime* out) {
  Scanner s(text);
  *out = {};
  return takeTime(&s, true, true, out) && s.atEnd();
}

}  // namespace vir::tables
