#pragma once
/// Columns that belong together.
#include <string>
#include <vector>

#include "vir/tables/layout.h"

namespace vir::tables {

/// Every head with each of the axes: `gyro_` gives gyro_x, gyro_y, gyro_z; with or without a unit
/// behind them (Layout::bare). False, and `out` as it was, unless all are there.
bool findAxes(const Layout& layout, const std::vector<std::string>& heads,
              const std::vector<std::string>& axes, int* out);

}  // namespace vir::tables
