#pragma once
/// Where the robot's antennas are, as a setting says it.
#include <cstddef>
#include <vector>

#include "input_error.h"
#include "vir/geometry/so3.h"

namespace vir {

/// Throws InputError unless there are three numbers, or three for each of several antennas.
inline void checkLeverArms(const std::vector<double>& lever_arm_m) {
  if (lever_arm_m.size() >= 3 && lever_arm_m.size() % 3 == 0) return;
  throw InputError(
      "lever_arm_m: give x y z in the body frame, or x y z of each label UWB0 UWB1 ...");
}

/// Does it say more than one?
inline bool saysSeveral(const std::vector<double>& lever_arm_m) { return lever_arm_m.size() > 3; }

/// Of the n-th label, in the body [m]: its own three numbers, else the first three.
inline Vec3 leverArm(const std::vector<double>& lever_arm_m, std::size_t n) {
  const std::size_t at = 3 * n + 2 < lever_arm_m.size() ? 3 * n : 0;
  return {lever_arm_m[at], lever_arm_m[at + 1], lever_arm_m[at + 2]};
}

}  // namespace vir
