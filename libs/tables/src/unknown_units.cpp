#include "vir/tables/unknown_units.h"

#include "units.h"
#include "vir/core/text.h"

namespace vir::tables {
namespace {

/// Behind the name of a column of stamps: a clock, or that there is no unit.
bool namesClock(const std::string& text) {
  for (const char* word : {"utc", "gps", "tai", "gmt", "unix", "posix", "epoch", "unix epoch",
                           "ros", "local", "-", "#", "1"}) {
    if (text == word) return true;
  }
  return false;
}

}  // namespace

std::string unknownUnits(const Layout& layout, const std::vector<int>& columns) {
  std::string out;
  for (const int column : columns) {
    const auto i = static_cast<std::size_t>(column);
    if (column < 0 || i >= layout.units.size() || layout.units[i].empty()) continue;
    const std::string& unit = layout.units[i];
    if (unitOfText(unit).quantity != Quantity::none || stampUnitOfText(unit)) continue;
    out += (out.empty() ? "" : ", ") + layout.names[i] + " [" + unit.substr(0, 40) + "]";
  }
  if (out.empty()) return out;
  return "its header names a unit that is not known: " + out +
         "; the numbers are taken to be in m, m/s^2 or rad/s: convert them, or name a known unit";
}

std::string unknownStampUnit(const Layout& layout, int column, StampUnit taken) {
  const auto i = static_cast<std::size_t>(column);
  if (column < 0 || i >= layout.units.size() || layout.units[i].empty()) return {};
  const std::string& unit = layout.units[i];
  if (layout.kind(column) != ColumnKind::other || stampUnitOfText(unit)) return {};
  if (namesClock(lowerCase(unit))) return {};
  return "its header names a unit of time that is not known: " + layout.names[i] + " [" +
         unit.substr(0, 40) +
         "]; known are s, ms, us and ns; by their size the stamps are taken to be in " +
         name(taken) + ": name a known unit if they are not";
}

}  // namespace vir::tables
