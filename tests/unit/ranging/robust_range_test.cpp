#include "vir/ranging/robust_range.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using vir::ranging::RobustRange;

TEST(RobustRange, ThePaperLossBelowZeroAndCauchyAbove) {
  const RobustRange robust{2.0, 1.5};
  for (const double r : {-30.0, -3.0, -1.0, -1e-3, -1e-9}) {
    const double rho = 4 * (std::sqrt(1 + r * r / 4) - 1);
    EXPECT_NEAR(robust.loss(r), rho, 1e-12 + 1e-6 * rho) << r;
    EXPECT_LT(robust.evaluate(r).e, 0);
  }
  for (const double r : {30.0, 3.0, 1.0, 1e-3}) {
    const double rho = 1.5 * 1.5 / 2 * std::log(1 + r * r / (1.5 * 1.5));
    EXPECT_NEAR(robust.loss(r), rho, 1e-9 * rho + 1e-16) << r;
    EXPECT_GT(robust.evaluate(r).e, 0);
  }
  // 1 m too long at 0.05 m weighs a small part of 1 m too short.
  EXPECT_LT(robust.loss(20), 0.2 * robust.loss(-20));
}

TEST(RobustRange, DerivativeAgreesWithDifferences) {
  const RobustRange robust;
  for (double r = -12; r < 12; r += 0.0937) {
    const double h = 1e-6;
    const double numeric = (robust.evaluate(r + h).e - robust.evaluate(r - h).e) / (2 * h);
    EXPECT_NEAR(robust.evaluate(r).de_dr, numeric, 1e-8) << r;
    const double slope = (robust.loss(r + h) - robust.loss(r - h)) / (2 * h);
    EXPECT_NEAR(robust.evaluate(r).influence() * r, slope, 1e-7) << r;
  }
}

TEST(RobustRange, SmoothAtZeroAndAcrossTheSeries) {
  const RobustRange robust;
  for (const double r : {-1e-12, 0.0, 1e-12}) {
    const auto v = robust.evaluate(r);
    EXPECT_NEAR(v.e, r, 1e-20);
    EXPECT_NEAR(v.de_dr, 1, 1e-11);
    EXPECT_NEAR(v.weight, 1, 1e-11);
    EXPECT_NEAR(v.influence(), 1, 1e-11);
  }
  const double edge = 1.5 * std::sqrt(1e-5);
  EXPECT_NEAR(robust.evaluate(edge * (1 - 1e-9)).de_dr, robust.evaluate(edge * (1 + 1e-9)).de_dr,
              1e-11);
}

TEST(RobustRange, EitherSideCanBeSwitchedOff) {
  const RobustRange none{0, -1};
  for (const double r : {-50.0, 50.0}) {
    EXPECT_EQ(none.evaluate(r).e, r);
    EXPECT_EQ(none.evaluate(r).weight, 1);
  }
}

TEST(RobustRange, FiniteForAnything) {
  const RobustRange robust;
  const double inf = std::numeric_limits<double>::infinity();
  for (const double r : {-inf, -1e300, 1e300, inf}) {
    const auto v = robust.evaluate(r);
    EXPECT_TRUE(std::isfinite(v.e) && std::isfinite(v.de_dr) && std::isfinite(v.weight)) << r;
    EXPECT_LT(v.weight, 1e-9);
  }
  const auto nan = robust.evaluate(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(nan.e, 0);
  EXPECT_EQ(nan.weight, 0);
  EXPECT_EQ(nan.influence(), 0);
}

}  // namespace
