#pragma once
#include "vir/geometry/pose.h"

namespace vir {
inline namespace geometry {

/// The pose between two others: position linear, attitude slerp (the shorter way round), `s` in
/// 0..1.
Pose interpolate(const Pose& a, const Pose& b, double s);

}  // namespace geometry
}  // namespace vir
