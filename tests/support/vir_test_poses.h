#pragma once
/// Poses at which factors are tested: level, pitched straight up and down, turned by almost half a
/// turn about each axis, and seeded random ones.
#include <random>
#include <string>
#include <vector>

#include "vir/geometry/pose.h"

namespace vir_test {

struct NamedPose {
  std::string name;
  vir::Pose T;
};

inline std::vector<NamedPose> poses() {
  using vir::expQuat;
  using vir::Pose;
  using vir::Vec3;
  const double degree = M_PI / 180;
  std::vector<NamedPose> out = {
      {"identity", Pose()},
      {"pitch +89.99 deg", Pose(expQuat(Vec3(0, 89.99 * degree, 0)), Vec3(1, -2, 0.5))},
      {"pitch -89.99 deg", Pose(expQuat(Vec3(0, -89.99 * degree, 0)), Vec3(-1, 2, 1.5))},
      {"179.99 deg about x", Pose(expQuat(Vec3(179.99 * degree, 0, 0)), Vec3(3, 0, 0))},
      {"179.99 deg about y", Pose(expQuat(Vec3(0, 179.99 * degree, 0)), Vec3(0, 3, 0))},
      {"179.99 deg about z", Pose(expQuat(Vec3(0, 0, 179.99 * degree)), Vec3(0, 0, 3))},
      {"180 deg about z, w < 0", Pose(vir::Quat(-0.0, 0, 0, -1), Vec3(0, 0, -3))},
  };
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int k = 0; k < 8; ++k) {
    const double a = u(random), b = u(random), c = u(random);
    const double x = u(random), y = u(random), z = u(random);
    out.push_back(
        {"random " + std::to_string(k), Pose(expQuat(1.8 * Vec3(a, b, c)), 5 * Vec3(x, y, z))});
  }
  return out;
}

}  // namespace vir_test
