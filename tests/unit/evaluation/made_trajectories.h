#pragma once
/// Motions for the tests of this folder.
#include <cmath>
#include <random>

#include "vir/evaluation/trajectory.h"

namespace vir::test {

/// A winding flight of `seconds` at `hz`, starting at a Unix-like stamp.
inline Trajectory winding(double seconds, double hz, TimeNs start = 1403636580838555555) {
  Trajectory result;
  const long n = std::lround(seconds * hz);
  for (long i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / hz;
    StampedPose pose;
    pose.t = start + fromSeconds(t);
    pose.T_W_B.p =
        Vec3(3 * std::sin(0.4 * t), 2 * std::cos(0.3 * t) + 0.1 * t, 1 + 0.5 * std::sin(0.7 * t));
    pose.T_W_B.q = expQuat(Vec3(0.3 * std::sin(t), -0.2 * std::cos(0.8 * t), 0)) *
                   expQuat(Vec3(0, 0, 0.5 * t));
    result.push_back(pose);
  }
  return result;
}

/// The same motion seen from another world: each pose turned by T_A_W, positions scaled first.
inline Trajectory seenFrom(const Trajectory& trajectory, const Pose& T_A_W, double scale = 1) {
  Trajectory result = trajectory;
  for (StampedPose& pose : result) {
    pose.T_W_B = T_A_W * Pose(pose.T_W_B.q, scale * pose.T_W_B.p);
  }
  return result;
}

/// Noise of fixed seed, drawn per pose.
inline Trajectory noisy(const Trajectory& trajectory, double sigma_m, double sigma_rad,
                        unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] {
    const double a = normal(generator), b = normal(generator), c = normal(generator);
    return Vec3(a, b, c);
  };
  Trajectory result = trajectory;
  for (StampedPose& pose : result) {
    pose.T_W_B.p += sigma_m * draw();
    pose.T_W_B.q = (pose.T_W_B.q * expQuat(sigma_rad * draw())).normalized();
  }
  return result;
}

}  // namespace vir::test
