#pragma once
/// Two robots that meet: paths, ranges between them, and what each one believes.
#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "vir/team/find_transform.h"
#include "vir_test_noise.h"

namespace vir::test {

using team::MutualRange;
using team::SharedAnchor;
using team::TransformOptions;
using team::WorldTransform;
using team::wrapAngle;

struct Meeting {
  team::WorldTransform truth{1.1, Vec3(3, -2, 0.4)};
  int ranges = 200;
  double rate_hz = 5;
  double sigma_m = 0.05;
  double slow_share = 0, slow_time_s = 2;  ///< of the ranges' errors
  double position_sigma_m = 0;             ///< of each robot, each axis
  double position_time_s = 30;
  double size_m = 3;    ///< of the paths
  double height_m = 1;  ///< of their vertical motion
  double nlos = 0;      ///< share of ranges lengthened by 0.3 to 4 m
  double anchor_sigma_m = 0.05;
};

struct MadeMeeting {
  std::vector<team::MutualRange> ranges;
  std::vector<team::SharedAnchor> anchors;
};

/// Ornstein-Uhlenbeck, standard deviation 1.
class SlowNoise {
 public:
  SlowNoise(Noise* noise, double time_s) : noise_(noise), time_s_(time_s), now_(noise->normal()) {}
  double next(double dt) {
    const double phi = std::exp(-dt / time_s_);
    return now_ = phi * now_ + std::sqrt(1 - phi * phi) * noise_->normal();
  }

 private:
  Noise* noise_;
  double time_s_, now_;
};

/// Each seed another pair of paths and another draw of errors.
inline MadeMeeting meet(const Meeting& m, std::uint64_t seed) {
  Noise noise(seed);
  double f[12];
  for (double& x : f) x = 0.15 + 0.35 * noise.uniform();
  double p[12];
  for (double& x : p) x = 2 * M_PI * noise.uniform();
  const Vec3 middle(m.size_m * (1 + noise.uniform()), m.size_m * noise.normal(), 0.3);
  std::vector<SlowNoise> slow;
  for (int i = 0; i < 6; ++i) slow.emplace_back(&noise, m.position_time_s);
  SlowNoise slow_range(&noise, m.slow_time_s);
  const team::WorldTransform T_B_A = m.truth.inverse();
  MadeMeeting out;
  const double dt = 1 / m.rate_hz;
  const Mat3 C = Mat3::Identity() * m.position_sigma_m * m.position_sigma_m;
  for (int i = 0; i < m.ranges; ++i) {
    const double t = i * dt;
    const auto wave = [&](int k) { return std::sin(2 * M_PI * f[k] * 0.3 * t + p[k]); };
    const Vec3 a(m.size_m * wave(0), m.size_m * wave(1), m.height_m * wave(2));
    const Vec3 b = middle + Vec3(m.size_m * wave(3), m.size_m * wave(4), m.height_m * wave(5));
    team::MutualRange r;
    r.t = fromSeconds(100 + t);
    r.sigma_m = m.sigma_m;
    r.range_m = (a - b).norm();
    const double s = slow_range.next(dt);
    r.range_m += m.sigma_m * (noise.normal() + m.slow_share * s);
    if (noise.uniform() < m.nlos) r.range_m += 0.3 + 3.7 * noise.uniform();
    Vec3 ea, eb;
    for (std::size_t k = 0; k < 3; ++k) {
      ea[static_cast<int>(k)] = m.position_sigma_m * slow[k].next(dt);
      eb[static_cast<int>(k)] = m.position_sigma_m * slow[k + 3].next(dt);
    }
    r.p_A = a + ea;
    r.p_B = T_B_A * b + eb;
    r.cov_A = r.cov_B = C;
    out.ranges.push_back(r);
  }
  team::SharedAnchor anchor;
  const Vec3 at(-m.size_m, 0.5 * m.size_m, 1);
  const auto error = [&] {
    return Vec3(m.anchor_sigma_m * Vec3(noise.normal(), noise.normal(), noise.normal()));
  };
  anchor.p_A = at + error();
  anchor.p_B = T_B_A * at + error();
  anchor.cov_A = anchor.cov_B = Mat3::Identity() * m.anchor_sigma_m * m.anchor_sigma_m;
  out.anchors.push_back(anchor);
  return out;
}

/// Without drift: what the simulated worlds do not do.
inline team::TransformOptions plainTransformOptions() {
  team::TransformOptions o;
  o.drift_m_per_sqrt_s = 0;
  o.drift_rad_per_sqrt_s = 0;
  return o;
}

inline Eigen::Vector4d errorOf(const team::WorldTransform& T, const team::WorldTransform& truth) {
  Eigen::Vector4d e;
  e[0] = team::wrapAngle(T.yaw_rad - truth.yaw_rad);
  e.tail<3>() = T.t_m - truth.t_m;
  return e;
}

}  // namespace vir::test
