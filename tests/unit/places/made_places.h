#pragma once
/// Keyframes made of points in space with random descriptors: what is true is known exactly.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "vir/core/random.h"
#include "vir/geometry/pose.h"
#include "vir/places/hamming.h"
#include "vir/types/loop.h"

namespace vir_test {

using KeyframePtr = std::shared_ptr<vir::PlaceKeyframe>;

inline vir::places::Descriptor randomDescriptor(vir::Random* random) {
  vir::places::Descriptor d;
  for (auto& byte : d) byte = static_cast<std::uint8_t>(random->below(256));
  return d;
}

/// Each bit turned with a probability.
inline vir::places::Descriptor disturbed(vir::places::Descriptor d, double share,
                                         vir::Random* random) {
  for (int bit = 0; bit < 256; ++bit) {
    if (random->uniform() < share) d[static_cast<std::size_t>(bit / 8)] ^= 1 << (bit % 8);
  }
  return d;
}

struct MadePoint {
  vir::Vec3 p_W = vir::Vec3::Zero();
  vir::places::Descriptor descriptor{};
};

/// Camera looking along the body's x axis, 90 by 60 degrees.
struct MadeWorld {
  std::vector<MadePoint> points;
  double noise_rad = 1 / 450.0;  ///< of a ray, per axis
  double flipped = 0.12;         ///< share of a descriptor's bits that change between views
  double outliers = 0;           ///< share of the points that look like another one
  double distance_sigma = 0.03;  ///< relative
  double known = 1;              ///< share of the points whose distance is known
  vir::Random random;

  /// Points 2 to 9 m around the origin.
  explicit MadeWorld(int n, std::uint64_t seed = 1) : random(seed) {
    for (int k = 0; k < n; ++k) {
      const double around = random.uniform(-3.14159, 3.14159), far = random.uniform(2, 9);
      points.push_back({vir::Vec3(far * std::cos(around), far * std::sin(around),
                                  random.uniform(-0.45, 0.45) * far),
                        randomDescriptor(&random)});
    }
  }

  static vir::Pose T_B_C() {
    vir::Mat3 R;
    R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return {vir::Quat(R), vir::Vec3(0.05, 0.02, -0.01)};
  }

  /// What is seen from T_W_B. The keyframe believes to be at `believed`.
  KeyframePtr see(std::uint64_t id, double s, const vir::Pose& T_W_B, const vir::Pose& believed,
                  std::size_t most = 200) {
    auto k = std::make_shared<vir::PlaceKeyframe>();
    k->id = id;
    k->t = vir::fromSeconds(s);
    k->T_W_B = believed;
    k->T_B_C = T_B_C();
    const vir::Pose T_C_W = (T_W_B * T_B_C()).inverse();
    for (const MadePoint& m : points) {
      const vir::Vec3 p_C = T_C_W * m.p_W;
      if (p_C.z() < 0.3 || std::abs(p_C.x()) > p_C.z() || std::abs(p_C.y()) > 0.577 * p_C.z()) {
        continue;
      }
      if (k->points.size() >= most) break;
      vir::PlacePoint p;
      const vir::Vec3 noise(random.normal(), random.normal(), random.normal());
      p.ray_C = (p_C.normalized() + noise_rad * noise).normalized().cast<float>();
      p.px = Eigen::Vector2f(450 * p.ray_C.x() / p.ray_C.z() + 450,
                             450 * p.ray_C.y() / p.ray_C.z() + 260);
      if (random.uniform() < known) {
        const double rho = 1 / p_C.norm();
        p.inverse_distance = static_cast<float>(rho * (1 + distance_sigma * random.normal()));
        p.inverse_distance_sigma = static_cast<float>(distance_sigma * rho);
      }
      const bool swapped = random.uniform() < outliers;
      const auto& d = swapped ? points[random.below(points.size())].descriptor : m.descriptor;
      p.descriptor = disturbed(d, flipped, &random);
      k->points.push_back(p);
    }
    return k;
  }
  KeyframePtr see(std::uint64_t id, double s, const vir::Pose& T_W_B) {
    return see(id, s, T_W_B, T_W_B);
  }
};

inline vir::Pose standing(const vir::Vec3& p, double yaw, double pitch = 0, double roll = 0) {
  return {vir::Quat(vir::rotZ(yaw)) * vir::expQuat(vir::Vec3(0, pitch, 0)) *
              vir::expQuat(vir::Vec3(roll, 0, 0)),
          p};
}

}  // namespace vir_test
