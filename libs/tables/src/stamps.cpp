#include "vir/tables/stamps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "vir/core/order_statistics.h"
#include "vir/core/parse_number.h"
#include "vir/core/time_bounds.h"

namespace vir::tables {
namespace {

constexpr double kFirstDate = 1.0e9, kLastDate = 4.1e9;  // 2001 and 2099 [s]
constexpr double kShortestStep = 1e-6, kLongestStep = 600;
constexpr std::array<StampUnit, 4> kUnits{StampUnit::nanoseconds, StampUnit::microseconds,
                                          StampUnit::milliseconds, StampUnit::seconds};

/// Decimal places between the unit and the nanosecond.
int places(StampUnit unit) {
  switch (unit) {
    case StampUnit::seconds:
      return 9;
    case StampUnit::milliseconds:
      return 6;
    case StampUnit::microseconds:
      return 3;
    case StampUnit::nanoseconds:
      break;
  }
  return 0;
}

/// 0.digits * 10^exponent.
struct Decimal {
  bool negative = false;
  std::string digits;
  int exponent = 0;
};

bool parseDecimal(std::string_view text, Decimal* d) {
  std::size_t i = 0;
  d->negative = !text.empty() && text[0] == '-';
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) ++i;
  bool point = false, any = false;
  for (; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.' && !point) {
      point = true;
      continue;
    }
    if (c < '0' || c > '9') break;
    any = true;
    if (c == '0' && d->digits.empty()) {
      if (point) --d->exponent;  // a zero right after the point
      continue;
    }
    d->digits += c;
    if (!point) ++d->exponent;
  }
  if (!any) return false;
  if (i == text.size()) return true;
  if (text[i] != 'e' && text[i] != 'E') return false;
  std::string_view exponent = text.substr(i + 1);
  int e = 0;
  if (exponent.substr(0, 1) == "+") exponent.remove_prefix(1);
  if (!parseNumber(exponent, &e) || e < -400 || e > 400) return false;
  d->exponent += e;
  return true;
}

struct Numbers {
  double first = 0, step = 0;  ///< step: the median of those that are not zero; 0: none
  bool any = false, fractions = false;
};

Numbers numbersOf(const std::vector<std::string>& stamps) {
  Numbers out;
  for (const std::string& text : stamps) {
    Decimal d;
    if (parseDecimal(text, &d) && static_cast<int>(d.digits.size()) > d.exponent) {
      out.fractions = true;
    }
  }
  // Integers of as small a part of whatever the unit is as 64 bits hold, where there are fractions:
  // differences of stamps in doubles would be coarse.
  StampUnit as = StampUnit::nanoseconds;
  if (out.fractions && !stamps.empty()) {
    for (const StampUnit unit : kUnits) {
      TimeNs t = 0;
      if (parseStamp(stamps.front(), unit, &t)) as = unit;
    }
  }
  const double scale = std::pow(10.0, -places(as));
  std::vector<double> steps;
  TimeNs before = 0;
  for (const std::string& text : stamps) {
    TimeNs t = 0;
    if (!parseStamp(text, as, &t)) continue;
    if (!out.any) out.first = static_cast<double>(t) * scale;
    if (out.any && t != before)
      steps.push_back(std::abs(static_cast<double>(timeBetween(before, t))) * scale);
    before = t;
    out.any = true;
  }
  if (!steps.empty()) out.step = medianInPlace(&steps);
  return out;
}

}  // namespace

const char* name(StampUnit unit) {
  switch (unit) {
    case StampUnit::seconds:
      return "s";
    case StampUnit::milliseconds:
      return "ms";
    case StampUnit::microseconds:
      return "us";
    case StampUnit::nanoseconds:
      break;
  }
  return "ns";
}

bool parseStamp(std::string_view text, StampUnit unit, TimeNs* t) {
  Decimal d;
  if (!parseDecimal(text, &d)) return false;
  *t = 0;
  const int keep = d.exponent + places(unit);  // digits in front of the nanosecond's point
  if (d.digits.empty() || keep < 0) return true;
  if (keep > 19) return false;
  const auto kept = static_cast<std::size_t>(keep);
  d.digits.resize(std::max(d.digits.size(), kept + 1), '0');
  std::uint64_t ns = 0;
  constexpr std::uint64_t kMax = std::numeric_limits<TimeNs>::max();
  for (std::size_t k = 0; k < kept; ++k) {
    const auto digit = static_cast<std::uint64_t>(d.digits[k] - '0');
    if (ns > (kMax - digit) / 10) return false;
    ns = ns * 10 + digit;
  }
  if (d.digits[kept] >= '5' && ns < kMax) ++ns;
  *t = d.negative ? -static_cast<TimeNs>(ns) : static_cast<TimeNs>(ns);
  return true;
}

bool addNanoseconds(std::string_view text, TimeNs* t) {
  TimeNs ns = 0;
  if (!parseStamp(text, StampUnit::nanoseconds, &ns) || ns < 0 || ns >= fromSeconds(1)) {
    return false;
  }
  if (*t > std::numeric_limits<TimeNs>::max() - ns) return false;
  *t += ns;
  return true;
}

UnitGuess guessUnit(const std::vector<std::string>& stamps, double typical_step_s,
                    std::optional<StampUnit> header) {
  const Numbers n = numbersOf(stamps);
  UnitGuess guess;
  guess.unit = header.value_or(n.fractions ? StampUnit::seconds : StampUnit::nanoseconds);
  if (!n.any) return guess;
  const auto plausible = [&](double scale) {
    return n.step == 0 || (n.step * scale > kShortestStep && n.step * scale < kLongestStep);
  };
  for (const StampUnit unit : kUnits) {
    const double scale = std::pow(10.0, places(unit) - 9);
    const double date = n.first * scale;
    if (date > kFirstDate && date < kLastDate && plausible(scale)) return {unit, true, true};
  }
  if (header && plausible(std::pow(10.0, places(*header) - 9))) {
    guess.sure = true;
    return guess;
  }
  if (n.step == 0) return guess;
  // Clocks since power-up: the units are a thousand apart, rates of a kind of sensor are not.
  double best = std::numeric_limits<double>::max();
  for (const StampUnit unit : kUnits) {
    const double off =
        std::abs(std::log(n.step * std::pow(10.0, places(unit) - 9) / typical_step_s));
    if (off < best) {
      best = off;
      guess.unit = unit;
    }
  }
  guess.sure = true;
  return guess;
}

}  // namespace vir::tables
