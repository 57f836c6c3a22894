/// How well a factor of ranges is known.
#include "range_scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vir/core/random.h"

namespace vir::check {
namespace {

constexpr double kFactor = 1.05, kNoise_m = 0.05;

/// 300 ranges on a path around the anchor, whose place is known.
AnchorFit heldFit(std::uint64_t seed) {
  Random random(seed);
  AnchorFit fit;
  fit.p_W = Vec3(4, -3, 2.5);
  fit.noise_m = kNoise_m;
  for (int i = 0; i < 300; ++i) {
    const double t = 0.2 * i;
    const Vec3 at(3 * std::cos(0.3 * t), 5 * std::sin(0.2 * t), 1 + std::sin(0.5 * t));
    fit.antennas_W.push_back(at);
    fit.ranges_m.push_back(kFactor * (fit.p_W - at).norm() + kNoise_m * random.normal());
    fit.times.push_back(fromSeconds(t));
  }
  fit.used = static_cast<long>(fit.times.size());
  fit.found = true;
  return fit;
}

TEST(RangeScale, ItsSigmaIsThatOfItsErrors) {
  constexpr int kSeeds = 60;
  double squares = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const AnchorFit fit = heldFit(static_cast<std::uint64_t>(seed));
    const RangeScale scale = commonScale({&fit}, true);
    ASSERT_TRUE(scale.found) << seed;
    EXPECT_EQ(scale.anchors, 1);
    squares += std::pow((scale.error - (kFactor - 1)) / scale.sigma, 2);
  }
  EXPECT_GT(std::sqrt(squares / kSeeds), 0.7);
  EXPECT_LT(std::sqrt(squares / kSeeds), 1.3);
}

TEST(RangeScale, TwoAnchorsKnowItBetter) {
  const AnchorFit a = heldFit(1), b = heldFit(2);
  const RangeScale one = commonScale({&a}, true), two = commonScale({&a, &b}, true);
  ASSERT_TRUE(one.found && two.found);
  EXPECT_EQ(two.anchors, 2);
  EXPECT_NEAR(two.sigma, one.sigma / std::sqrt(2.0), 0.1 * one.sigma);
}

}  // namespace
}  // namespace vir::check
