#include "axes.h"

#include <algorithm>

namespace vir::tables {

bool findAxes(const Layout& layout, const std::vector<std::string>& heads,
              const std::vector<std::string>& axes, int* out) {
  const std::vector<std::string>& names = layout.bare;
  for (const std::string& head : heads) {
    std::vector<int> found;
    for (const std::string& axis : axes) {
      auto at = std::find(layout.names.begin(), layout.names.end(), head + axis);
      auto i = at - layout.names.begin();
      if (at == layout.names.end()) {
        i = std::find(names.begin(), names.end(), head + axis) - names.begin();
      }
      found.push_back(i < static_cast<std::ptrdiff_t>(names.size()) ? static_cast<int>(i) : -1);
    }
    if (std::all_of(found.begin(), found.end(), [](int i) { return i >= 0; })) {
      std::copy(found.begin(), found.end(), out);
      return true;
    }
  }
  return false;
}

}  // namespace vir::tables
