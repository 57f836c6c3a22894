#pragma once
/// Whether a pose can be used at all.
#include "vir/geometry/pose.h"

namespace vir {
inline namespace geometry {

/// All of its numbers are; nothing is said about the length of the quaternion.
inline bool isFinite(const Pose& T_A_B) {
  return T_A_B.p.allFinite() && T_A_B.q.coeffs().allFinite();
}

}  // namespace geometry
}  // namespace vir
