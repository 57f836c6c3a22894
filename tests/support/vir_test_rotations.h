#pragma once
/// Rotation vectors at which formulas for SO(3) tend to break: none, tiny, the switch points of the
/// series, right angles, almost and exactly half a turn.
#include <random>
#include <vector>

#include "vir/geometry/so3.h"

namespace vir_test {

inline std::vector<vir::Vec3> rotationVectors() {
  using vir::Vec3;
  std::vector<Vec3> out = {Vec3::Zero()};
  const std::vector<Vec3> axes = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitY(),
                                  Vec3(1, -2, 3).normalized()};
  for (double angle : {1e-12, 1e-9, 1e-7, 1e-5, 0.99e-4, 1.01e-4, 0.99e-3, 1.01e-3, 0.99e-2,
                       1.01e-2, 0.3, M_PI / 2, 3.0, M_PI - 1e-3, M_PI - 1e-6}) {
    for (const Vec3& axis : axes) out.push_back(angle * axis);
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-1.8, 1.8);
  for (int k = 0; k < 20; ++k) out.emplace_back(u(random), u(random), u(random));
  return out;
}

}  // namespace vir_test
