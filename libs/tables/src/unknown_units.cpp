#include "vir/tables/unknown_units.h"

#include "units.h"

namespace vir::tables {

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

}  // namespace vir::tables
