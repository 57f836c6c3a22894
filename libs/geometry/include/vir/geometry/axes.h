#pragma once
#include <string>

#include "vir/geometry/so3.h"

namespace vir {
inline namespace geometry {

/// Three words, the axis of frame A, with its sign, that each of x, y, z of frame B is:
/// "x -y -z" for an A whose y points right and z down and a B with y left and z up.
/// R_B_A, a rotation by quarter turns. Throws std::invalid_argument for anything else.
Mat3 axesRotation(const std::string& text);

}  // namespace geometry
}  // namespace vir
