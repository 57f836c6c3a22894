/// An anchor whose ranges are half a metre too long is where it is, if its bias may be so large.
#include <gtest/gtest.h>

#include "made_ranges.h"

namespace vir::ranging {
namespace {

using test::fly;
using test::plainOptions;

test::Flight wide(double bias) {
  test::Flight f;
  f.amplitude = Vec3(4, 4, 2);
  f.bias = bias;
  return f;
}

AnchorInitOptions withBias(double sigma_m) {
  AnchorInitOptions o = plainOptions();
  o.bias_sigma_m = sigma_m;
  return o;
}

TEST(UncalibratedBoard, IsPlacedWithTheFreeBias) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const test::Flight f = wide(0.6);
    const AnchorInitialization r = initializeAnchor(fly(f, seed), withBias(0.7));
    ASSERT_EQ(r.geometry, AnchorGeometry::good) << r.advice;
    EXPECT_LT((r.solutions[0].p_W - f.anchor).norm(), 0.1) << seed;
    EXPECT_NEAR(r.solutions[0].bias_m, 0.6, 0.1) << seed;
  }
}

TEST(UncalibratedBoard, HeldToACalibratedBiasItIsElsewhere) {
  const test::Flight f = wide(0.6);
  const AnchorInitialization r = initializeAnchor(fly(f), withBias(0.03));
  const bool wrong =
      r.geometry != AnchorGeometry::good || (r.solutions[0].p_W - f.anchor).norm() > 0.1;
  EXPECT_TRUE(wrong) << "or the free bias would not be needed";
}

TEST(UncalibratedBoard, ExactRangesDoNotSeeABias) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const test::Flight f = wide(0);
    const AnchorInitialization r = initializeAnchor(fly(f, seed), withBias(0.7));
    ASSERT_EQ(r.geometry, AnchorGeometry::good) << r.advice;
    const double sigma = std::sqrt(r.solutions[0].covariance(3, 3));
    EXPECT_LT(std::abs(r.solutions[0].bias_m), 4 * sigma) << "no sign of a bias, seed " << seed;
  }
}

}  // namespace
}  // namespace vir::ranging
