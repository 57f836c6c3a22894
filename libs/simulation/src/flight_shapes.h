#pragma once
/// The lines that made-up flights follow.
#include <string>
#include <vector>

#include "vir/geometry/so3.h"

namespace vir::simulation {

/// Points of the line `name`, `length_m` long, from the origin on; shapes that close are repeated.
/// Empty for a name that is none of shapeNames().
std::vector<Vec3> shapePoints(const std::string& name, double length_m);
std::vector<std::string> shapeNames();

}  // namespace vir::simulation
