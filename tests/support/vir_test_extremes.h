#pragma once
/// Numbers that are no measurements, for the tests of everything that takes numbers.
#include <array>
#include <cstddef>
#include <limits>

#include "vir/geometry/so3.h"

namespace vir::test {

inline const std::array<double, 16>& extremes() {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  static const std::array<double, 16> all{0,
                                          -0.0,
                                          std::numeric_limits<double>::denorm_min(),
                                          1e-300,
                                          -1e-300,
                                          1e-18,
                                          1,
                                          1e9,
                                          -1e18,
                                          1e18,
                                          1e154,
                                          1e308,
                                          -1e308,
                                          kInfinite,
                                          -kInfinite,
                                          std::numeric_limits<double>::quiet_NaN()};
  return all;
}

/// Each at one place at a time, at two of them, and everywhere: calls `tried(Vec3)`.
template <typename Tried>
void forExtremeVectors(const Vec3& usual, const Tried& tried) {
  for (const double x : extremes()) {
    for (int i = 0; i < 3; ++i) {
      Vec3 one = usual, two = Vec3::Constant(x);
      one[i] = x;
      two[i] = usual[i];
      tried(one);
      tried(two);
    }
    tried(Vec3::Constant(x));
  }
}

}  // namespace vir::test
