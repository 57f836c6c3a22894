/// Does the covariance of an initialised anchor tell the truth? Normalised error squared over 200
/// seeds, whose mean is the dimension.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "made_ranges.h"

namespace {

using vir::Vec3;
using vir::test::Flight;
using vir::test::fly;
using vir::test::Noise;
using vir::test::plainOptions;

/// Mean over the seeds, of the solution nearer to the truth (position and bias: 4 dimensions).
double meanNees(Flight f, double share_of_ar = 0) {
  constexpr int kSeeds = 200;
  double sum = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    auto ranges = fly(f, seed);
    if (share_of_ar > 0) {
      Noise noise(seed + 1000);
      double x = noise.normal();
      for (auto& r : ranges) {
        x = 0.86 * x + std::sqrt(1 - 0.86 * 0.86) * noise.normal();
        r.range_m += f.sigma * x;
      }
    }
    const auto result = vir::ranging::initializeAnchor(ranges, plainOptions());
    double least = 1e9;
    for (const auto& s : result.solutions) {
      Eigen::Vector4d e;
      e << s.p_W - f.anchor, s.bias_m - f.bias;
      least = std::min(least, e.dot(s.covariance.inverse() * e));
    }
    sum += least / kSeeds;
  }
  return sum;
}

void expectConsistent(double nees) {
  EXPECT_GT(nees, 0.7 * 4);
  EXPECT_LT(nees, 1.5 * 4);
}

TEST(AnchorConsistency, MotionInSpace) { expectConsistent(meanNees(Flight())); }

TEST(AnchorConsistency, MotionInAPlane) {
  Flight f;
  f.amplitude.z() = 0;
  expectConsistent(meanNees(f));
}

TEST(AnchorConsistency, FarAway) {
  Flight f;
  f.anchor = Vec3(80, 60, 3);
  f.amplitude = Vec3(20, 20, 5);
  expectConsistent(meanNees(f));
}

TEST(AnchorConsistency, ThirtyPerCentWithoutLineOfSight) {
  Flight f;
  f.nlos = 0.3;
  expectConsistent(meanNees(f));
}

TEST(AnchorConsistency, ManyRanges) {
  Flight f;
  f.ranges = 1000;
  expectConsistent(meanNees(f));
}

TEST(AnchorConsistency, CorrelatedRanges) {
  // What the ranges claim is right for each, but they resemble one another: taken as white, the
  // mean would be near 40.
  Flight f;
  f.noise = false;
  f.ranges = 600;
  const double nees = meanNees(f, 1);
  EXPECT_GT(nees, 0.4 * 4);
  EXPECT_LT(nees, 2.0 * 4);
}

}  // namespace
