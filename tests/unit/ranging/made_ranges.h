#pragma once
/// Flights past an anchor.
#include <cmath>
#include <vector>

#include "vir/ranging/anchor_initialization.h"
#include "vir_test_noise.h"

namespace vir::test {

struct Flight {
  Vec3 amplitude = Vec3(2, 2, 1);  ///< of three incommensurate oscillations [m]
  Mat3 turn = Mat3::Identity();    ///< applied to the path
  Vec3 anchor = Vec3(3, 1, 2);
  int ranges = 300;
  double sigma = 0.05, bias = 0;
  double nlos = 0;  ///< share of ranges lengthened by 0.3 to 1.8 m
  bool noise = true;
};

inline std::vector<ranging::AntennaRange> fly(const Flight& f, std::uint64_t seed = 1) {
  Noise noise(seed);
  std::vector<ranging::AntennaRange> out;
  for (int i = 0; i < f.ranges; ++i) {
    const double t = 15.0 * i / f.ranges;
    ranging::AntennaRange r;
    r.p_W = f.turn * Vec3(f.amplitude.x() * std::sin(0.5 * t),
                          f.amplitude.y() * std::sin(0.7 * t + 0.3),
                          f.amplitude.z() * std::sin(0.9 * t + 1));
    r.sigma_m = f.sigma;
    r.range_m = (f.anchor - r.p_W).norm() + f.bias + (f.noise ? f.sigma * noise.normal() : 0.0);
    if (f.nlos > 0 && noise.uniform() < f.nlos) r.range_m += 0.3 + 1.5 * noise.uniform();
    out.push_back(r);
  }
  return out;
}

/// No drift of the path unless a test is about it.
inline ranging::AnchorInitOptions plainOptions() {
  ranging::AnchorInitOptions options;
  options.drift_ratio = 0;
  return options;
}

}  // namespace vir::test
