#include "vir/tables/by_position.h"

#include <algorithm>

#include "units.h"

namespace vir::tables {

bool hasHeader(const Layout& layout) {
  if (layout.names.empty() || layout.names.size() < layout.columns) return false;
  if (layout.header_separator != layout.separator) return false;
  if (layout.separator != ' ') return true;
  const bool units = std::any_of(layout.units.begin(), layout.units.end(),
                                 [](const std::string& unit) { return !unit.empty(); });
  return units || namedStampColumn(layout) >= 0;
}

std::string takenByPosition(const Layout& layout, const Taken& taken, bool by_units) {
  if (!hasHeader(layout)) return {};
  std::string out;
  for (const auto& [column, what] : taken) {
    const auto i = static_cast<std::size_t>(column);
    if (column < 0 || i >= layout.written.size()) continue;
    out += (out.empty() ? "" : ", ") + layout.written[i].substr(0, 40);
    if (!layout.units[i].empty()) out += " [" + layout.units[i].substr(0, 20) + "]";
    out += " as " + what;
  }
  return std::string("the names of its columns are not known; taken by ") +
         (by_units ? "their units: " : "position: ") + out +
         (by_units ? "" : "; name them as in `t,gyro_x,...` if that is wrong");
}

void addAxes(const int columns[3], const std::string& what, Taken* taken) {
  const char* const axes[3] = {" x", " y", " z"};
  for (int i = 0; i < 3; ++i) taken->push_back({columns[i], what + axes[i]});
}

}  // namespace vir::tables
