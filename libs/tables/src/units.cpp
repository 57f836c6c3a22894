#include "units.h"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <utility>

#include "vir/core/angles.h"
#include "vir/core/text.h"

namespace vir::tables {
namespace {

constexpr double kGravity = 9.80665;

bool isAnyOf(std::string_view text, std::initializer_list<std::string_view> all) {
  return std::find(all.begin(), all.end(), text) != all.end();
}

/// Takes the first of these that stands in front.
bool takeFront(std::string_view* text, std::initializer_list<std::string_view> fronts) {
  for (const std::string_view front : fronts) {
    if (text->substr(0, front.size()) != front) continue;
    text->remove_prefix(front.size());
    return true;
  }
  return false;
}

bool perSecond(std::string_view text) {
  return isAnyOf(text, {"s", "s1", "ps", "pers", "sec", "sec1", "persec", "psec", "second",
                        "second1", "seconds", "persecond"});
}

bool perSecondSquared(std::string_view text) {
  return isAnyOf(text, {"s2",     "ss",        "ps2",     "pss",      "pers2",         "sec2",
                        "secsec", "persec2",   "second2", "seconds2", "persecond2",    "ssquared",
                        "sps",    "spersec",   "sqs",     "ssq",      "secondsquared", "psps",
                        "s22",    "secsquared"});
}

/// With each prefix that may stand in front, none first.
std::initializer_list<std::pair<std::string_view, double>> prefixes() {
  static const std::initializer_list<std::pair<std::string_view, double>> all{
      {"", 1.0}, {"milli", 1e-3}, {"micro", 1e-6}, {"m", 1e-3}, {"u", 1e-6}, {"n", 1e-9}};
  return all;
}

std::optional<Unit> angleOrRate(std::string_view text, double scale) {
  const bool rad = takeFront(&text, {"radians", "radian", "rad"});
  if (text == "dps") return Unit{Quantity::rate, scale * kRadPerDeg};
  if (!rad && !takeFront(&text, {"degrees", "degree", "deg"})) return std::nullopt;
  const double factor = scale * (rad ? 1.0 : kRadPerDeg);
  if (text.empty()) return Unit{Quantity::angle, factor};
  if (perSecond(text)) return Unit{Quantity::rate, factor};
  if (isAnyOf(text, {"h", "h1", "hr", "ph", "hour", "perhour"})) {
    return Unit{Quantity::rate, factor / 3600};
  }
  return std::nullopt;
}

std::optional<Unit> lengthAndItsRates(std::string_view text) {
  struct Length {
    std::initializer_list<std::string_view> names;
    double factor;
  };
  static const Length lengths[]{
      {{"millimeters", "millimetres", "millimeter", "millimetre", "mm"}, 1e-3},
      {{"centimeters", "centimetres", "centimeter", "centimetre", "cm"}, 1e-2},
      {{"kilometers", "kilometres", "kilometer", "kilometre", "km"}, 1e3},
      {{"meters", "metres", "meter", "metre", "m"}, 1.0},
      {{"feet", "foot", "ft"}, 0.3048}};
  for (const Length& length : lengths) {
    std::string_view rest = text;
    if (!takeFront(&rest, length.names)) continue;
    if (rest.empty()) return Unit{Quantity::length, length.factor};
    if (perSecondSquared(rest)) return Unit{Quantity::force, length.factor};
    if (perSecond(rest)) return Unit{Quantity::speed, length.factor};
  }
  return std::nullopt;
}

}  // namespace

std::string asciiUnits(std::string_view text) {
  static const std::pair<std::string_view, std::string_view> signs[]{
      {"\xC2\xB5", "u"}, {"\xCE\xBC", "u"},     {"\xC2\xB0", "deg"}, {"\xC2\xB2", "2"},
      {"\xC2\xB7", " "}, {"\xE2\x81\xBB", "-"}, {"\xC2\xB9", "1"}};
  std::string out;
  while (!text.empty()) {
    const auto* sign = std::find_if(std::begin(signs), std::end(signs), [&](const auto& s) {
      return text.substr(0, s.first.size()) == s.first;
    });
    if (sign != std::end(signs)) {
      out += sign->second;
      text.remove_prefix(sign->first.size());
      continue;
    }
    // Alone, not as the second byte of another letter: Latin-1.
    const auto before = out.empty() ? '\0' : out.back();
    const bool alone = static_cast<unsigned char>(before) < 0x80;
    const auto c = static_cast<unsigned char>(text.front());
    if (alone && c == 0xB5) {
      out += 'u';
    } else if (alone && c == 0xB0) {
      out += "deg";
    } else if (alone && c == 0xB2) {
      out += '2';
    } else {
      out += text.front();
    }
    text.remove_prefix(1);
  }
  return out;
}

namespace {

/// Letters and digits in lower case.
std::string canonical(std::string_view text) {
  std::string out;
  for (const char c : asciiUnits(text)) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) out += c;
  }
  return lowerCase(out);
}

/// The last part of a name that is a unit: where it begins, behind an underline.
std::size_t unitBehind(const std::string& name, Unit* unit) {
  for (std::size_t at = name.find('_'); at != name.npos; at = name.find('_', at + 1)) {
    const std::string behind = name.substr(at + 1);
    *unit = at == 0 ? Unit{} : unitOfText(behind);
    if (unit->quantity != Quantity::none) return at;
  }
  return name.npos;
}

}  // namespace

Unit unitOfText(std::string_view written) {
  const std::string text = canonical(written);
  if (text == "rps") return {Quantity::rate, 1.0};
  if (text == "rpm") return {Quantity::rate, 6 * kRadPerDeg};
  for (const auto& [front, scale] : prefixes()) {
    std::string_view rest = text;
    if (rest.substr(0, front.size()) != front) continue;
    rest.remove_prefix(front.size());
    if (const auto turn = angleOrRate(rest, scale)) return *turn;
    if (isAnyOf(rest, {"g", "gs", "g0", "gn", "gee", "gees", "gravity"})) {
      return {Quantity::force, scale * kGravity};
    }
    const bool tesla = isAnyOf(rest, {"t", "tesla"}) && !front.empty();
    if (tesla || rest == "gauss") return {Quantity::field, scale};
  }
  return lengthAndItsRates(text).value_or(Unit{});
}

std::optional<StampUnit> stampUnitOfText(std::string_view written) {
  const std::string text = canonical(written);
  if (isAnyOf(text, {"ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecond", "nanoseconds"})) {
    return StampUnit::nanoseconds;
  }
  if (isAnyOf(text, {"us", "usec", "usecs", "micros", "microsec", "microsecond", "microseconds"})) {
    return StampUnit::microseconds;
  }
  if (isAnyOf(text, {"ms", "msec", "msecs", "millis", "millisec", "millisecond", "milliseconds"})) {
    return StampUnit::milliseconds;
  }
  if (isAnyOf(text, {"s", "sec", "secs", "second", "seconds"})) return StampUnit::seconds;
  return std::nullopt;
}

std::string bareName(std::string name) {
  for (const char* front : {"field_", "imu0_", "imu_", "msg_", "data_", "sensor_", "gt_", "truth_",
                            "groundtruth_", "ground_truth_"}) {
    const std::string f(front);
    if (name.size() > f.size() + 1 && name.compare(0, f.size(), f) == 0) name.erase(0, f.size());
  }
  Unit unit;
  const std::size_t at = unitBehind(name, &unit);
  if (at == name.npos) return name;
  name.resize(at);
  if (name.size() > 3 && name.compare(name.size() - 3, 3, "_in") == 0) name.resize(name.size() - 3);
  return name;
}

Unit unitAt(const Layout& layout, int column) {
  const auto i = static_cast<std::size_t>(column);
  if (column < 0 || i >= layout.names.size()) return {};
  if (!layout.units[i].empty()) return unitOfText(layout.units[i]);
  Unit unit;
  return unitBehind(layout.names[i], &unit) == std::string::npos ? Unit{} : unit;
}

double rateUnit(const Layout& layout, int column) {
  const Unit unit = unitAt(layout, column);
  // Of a gyro they mean the rate.
  return unit.quantity == Quantity::rate || unit.quantity == Quantity::angle ? unit.factor : 1.0;
}

double forceUnit(const Layout& layout, const int columns[3]) {
  constexpr double kLeast = 0.05 * kGravity, kMost = 5 * kGravity;
  const Unit unit = unitAt(layout, columns[0]);
  if (unit.quantity != Quantity::force) return 1.0;
  const double size = medianNorm(layout, columns) * unit.factor;
  return unit.factor > 1 ? (size < kMost ? unit.factor : 1.0) : (size > kLeast ? unit.factor : 1.0);
}

double lengthUnit(const Layout& layout, int column) {
  const Unit unit = unitAt(layout, column);
  return unit.quantity == Quantity::length ? unit.factor : 1.0;
}

}  // namespace vir::tables
