#pragma once
/// How well matches between two cameras fit a way in which these stand to each other.
#include <algorithm>
#include <array>
#include <cmath>

#include "vir/check/rig_check.h"

namespace vir::check {

constexpr double kNearLinePx = 2;
constexpr float kMostBits = 50;  ///< that descriptors of one thing differ by
/// Of matches that fit: a calibration that is right, one that another must be better than by so
/// much to be named, and what chance alone gives.
constexpr double kGood = 0.6, kBetterBy = 0.2, kChance = 0.2;

/// Sine of the angle between the first ray and the plane of the second and the baseline.
inline double offLine(const std::array<Vec3, 2>& rays, const Pose& T_0_1) {
  const Vec3 normal = T_0_1.p.cross(T_0_1.R() * rays[1]);
  const double n = normal.norm();
  return n > 1e-9 ? rays[0].dot(normal) / n : 0;
}

struct RigCheck::Fit {
  std::size_t of = 0;      ///< matches whose rays the models know
  double share = 0;        ///< of them on their epipolar line and in front of both cameras
  double median_px = 0;    ///< distance from the line
  double parallax_px = 0;  ///< median of those that fit
};

}  // namespace vir::check
