/// Offsets between worlds whose robots moved in a line: the ring about it, at four places.
#include "trilateration.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vir::team {
namespace {

TEST(Trilateration, TheRingAboutALineIsTriedOnAllSides) {
  const Vec3 truth(2, 3, 1);
  std::vector<MutualRange> ranges;
  for (int k = 0; k < 12; ++k) {
    MutualRange m;
    m.p_A = Vec3(0.7 * k - 2, 0, 0);
    m.range_m = (m.p_A - truth).norm();
    ranges.push_back(m);
  }
  const auto t = Trilateration(ranges).solve(0);
  const double radius = std::hypot(3, 1);
  for (std::size_t i = 3; i < Trilateration::kBranches; ++i) {
    ASSERT_TRUE(t[i]) << i;
    EXPECT_NEAR(t[i]->x(), 2, 1e-6) << i;
    EXPECT_NEAR(t[i]->tail<2>().norm(), radius, 1e-6) << i;
    for (std::size_t k = i + 1; k < Trilateration::kBranches; ++k) {
      EXPECT_GT((*t[i] - *t[k]).norm(), radius) << i << " and " << k << " are two places";
    }
  }
  EXPECT_LT((*t[3] + *t[4] - 2 * Vec3(2, 0, 0)).norm(), 1e-6);
  EXPECT_LT((*t[5] + *t[6] - 2 * Vec3(2, 0, 0)).norm(), 1e-6);
}

}  // namespace
}  // namespace vir::team
