#include "vir/core/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using vir::Random;

TEST(RandomNumbers, HaveTheirMoments) {
  Random r(7, 3);
  double sum = 0, square = 0, fourth = 0;
  constexpr int n = 200000;
  for (int k = 0; k < n; ++k) {
    const double x = r.normal();
    sum += x;
    square += x * x;
    fourth += x * x * x * x;
  }
  EXPECT_NEAR(sum / n, 0, 0.01);      // 4 sigma
  EXPECT_NEAR(square / n, 1, 0.013);  // 4 sigma
  EXPECT_NEAR(fourth / n, 3, 0.1);
}

TEST(RandomNumbers, StreamsAreIndependent) {
  Random a(1, 0), b(1, 1), c(2, 0);
  double ab = 0, ac = 0;
  constexpr int n = 50000;
  for (int k = 0; k < n; ++k) {
    const double x = a.normal();
    ab += x * b.normal();
    ac += x * c.normal();
  }
  EXPECT_LT(std::abs(ab / n), 0.02);
  EXPECT_LT(std::abs(ac / n), 0.02);
}

TEST(RandomNumbers, BelowReachesAllAndNoMore) {
  Random r(3);
  int seen[5] = {};
  for (int k = 0; k < 1000; ++k) ++seen[r.below(5)];
  for (const int n : seen) EXPECT_NEAR(n, 200, 60);
}

TEST(RandomNumbers, SameSeedSameNumbers) {
  Random a(5, 9), b(5, 9);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(a.uniform(), b.uniform());
}

TEST(RandomNumbers, UniformStaysInItsBounds) {
  Random r(1);
  for (int k = 0; k < 10000; ++k) {
    const double x = r.uniform(-2, 3);
    ASSERT_GE(x, -2);
    ASSERT_LT(x, 3);
  }
}

}  // namespace
