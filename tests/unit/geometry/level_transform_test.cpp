#include "vir/geometry/level_transform.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vir {
namespace {

TEST(LevelTransform, IsFoundFromPointsKnownInBothFrames) {
  const LevelTransform T_A_B{2.1, Vec3(3, -4, 0.5)};
  std::vector<LevelPair> pairs;
  for (const Vec3& p : {Vec3(0, 0, 1), Vec3(5, 0, 2), Vec3(1, 7, 0)}) {
    pairs.push_back({T_A_B * p, p, 1.0 + static_cast<double>(pairs.size())});
  }
  const LevelFit fit = fitLevel(pairs);
  EXPECT_NEAR(fit.T_A_B.yaw_rad, 2.1, 1e-12);
  EXPECT_LT((fit.T_A_B.t_m - T_A_B.t_m).norm(), 1e-12);
  EXPECT_TRUE(fit.turn_known);
  EXPECT_NEAR(fit.weight, 6, 1e-12);
  EXPECT_NEAR(fit.cost, 0, 1e-20);
  EXPECT_LT(((T_A_B.inverse() * T_A_B).t_m).norm(), 1e-12);
}

TEST(LevelTransform, LeavesTheLeastSquares) {
  std::vector<LevelPair> pairs{{Vec3(0.1, 0, 0), Vec3(0, 0, 0), 1},
                               {Vec3(4, 0.2, 0.1), Vec3(4, 0, 0), 4},
                               {Vec3(0, 3, -0.1), Vec3(0, 3.1, 0), 2}};
  const LevelFit fit = fitLevel(pairs);
  const auto cost = [&](const LevelTransform& T) {
    double sum = 0;
    for (const LevelPair& p : pairs) sum += p.weight * (T * p.p_B - p.p_A).squaredNorm();
    return sum;
  };
  EXPECT_NEAR(fit.cost, cost(fit.T_A_B), 1e-12);
  for (int k = 0; k < 4; ++k) {
    for (const double step : {-1e-3, 1e-3}) {
      LevelTransform T = fit.T_A_B;
      if (k == 3) {
        T.yaw_rad += step;
      } else {
        T.t_m[k] += step;
      }
      EXPECT_GT(cost(T), fit.cost) << k;
    }
  }
  const double h = 1e-6;
  const LevelTransform turned{fit.T_A_B.yaw_rad + h, Vec3::Zero()};
  const Vec3 arm(1, 2, 3);
  const Vec3 numeric = (turned * arm - LevelTransform{fit.T_A_B.yaw_rad, Vec3::Zero()} * arm) / h;
  EXPECT_LT((fit.swing(fit.centre_B + arm) - numeric).norm(), 1e-5);
}

TEST(LevelTransform, OnePointSaysNothingOfTheTurn) {
  const LevelFit one = fitLevel({{Vec3(1, 2, 3), Vec3(4, 4, 4), 9}});
  EXPECT_FALSE(one.turn_known);
  EXPECT_EQ(one.T_A_B.yaw_rad, 0);
  EXPECT_LT((one.T_A_B * Vec3(4, 4, 4) - Vec3(1, 2, 3)).norm(), 1e-12);
  const LevelFit upright =
      fitLevel({{Vec3(1, 2, 3), Vec3(4, 4, 4), 9}, {Vec3(1, 2, 5), Vec3(4, 4, 6), 9}});
  EXPECT_FALSE(upright.turn_known);
  EXPECT_EQ(fitLevel({}).weight, 0);
}

}  // namespace
}  // namespace vir
