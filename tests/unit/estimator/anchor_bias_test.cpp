/// Uncalibrated UWB boards: their ranges tell what they read too long; calibrated ones stay held.
#include <gtest/gtest.h>

#include <cmath>

#include "odometry_range_driver.h"

namespace vir::estimator {
namespace {

using vir_test::flightOf;
using vir_test::fly;
using vir_test::RangeRun;
using vir_test::rangesTo;
using vir_test::RangeWorld;

const Vec3 kAnchor(4, 6, 2.5);

/// An odometry about as good as camera and IMU.
simulation::OdometrySimulationOptions fine(int seed) {
  simulation::OdometrySimulationOptions o;
  o.scale_error = o.scale_wander = 0.001;
  o.yaw_walk = 0.0005;
  o.position_walk = 0.001;
  o.seed = seed;
  return o;
}

RangeWorld worldWith(double bias_m, int seed) {
  simulation::RangeSimulationOptions ranges = rangesTo({kAnchor}, seed);
  ranges.bias_m = bias_m;
  return RangeWorld(simulation::flight("eight", flightOf(60, seed)), fine(seed), ranges);
}

TEST(AnchorBias, AnUncalibratedBoardIsToldAndItsAnchorPlaced) {
  for (const double bias : {0.6, -0.4}) {
    for (const int seed : {1, 2, 3}) {
      const RangeWorld world = worldWith(bias, seed);
      const RangeRun run = fly(world);
      const Anchor* a = run.anchor(0);
      ASSERT_TRUE(a != nullptr && a->has_position) << bias << " " << seed;
      EXPECT_LT((a->p_W - world.anchor(0)).norm(), 0.1) << bias << " seed " << seed;
      EXPECT_NEAR(a->bias_m, bias, 0.1) << "seed " << seed;
      EXPECT_LT(std::abs(a->bias_m - bias), 4 * a->bias_sigma_m) << "seed " << seed;
    }
  }
}

TEST(AnchorBias, ExactRangesKeepTheCalibratedBoard) {
  for (const int seed : {1, 2, 3}) {
    const RangeWorld world = worldWith(0, seed);
    const RangeRun run = fly(world);
    const Anchor* a = run.anchor(0);
    ASSERT_TRUE(a != nullptr && a->has_position);
    EXPECT_LT((a->p_W - world.anchor(0)).norm(), 0.1) << "seed " << seed;
    EXPECT_LT(std::abs(a->bias_m), 0.05) << "seed " << seed;
    EXPECT_LE(a->bias_sigma_m, 0.031) << "held by a calibrated board's prior, seed " << seed;
    EXPECT_FALSE(run.warned("uncalibrated")) << "seed " << seed;
  }
}

TEST(AnchorBias, ACalibratedBoardIsHeldWhereAllAreSaidToBe) {
  const RangeWorld world = worldWith(0.6, 1);
  OdometryRangeConfig config;
  config.ranges.uncalibrated_bias_sigma_m = 0;
  const RangeRun run = fly(world, config);
  EXPECT_FALSE(run.warned("uncalibrated"));
  const Anchor* a = run.anchor(0);
  ASSERT_TRUE(a != nullptr);
  EXPECT_LE(a->bias_sigma_m, 0.031);
}

TEST(AnchorBias, CostsTheTrajectoryNothing) {
  for (const int seed : {1, 2, 3}) {
    const RangeWorld exact = worldWith(0, seed), biased = worldWith(0.6, seed);
    const double without = vir_test::ate(exact, fly(exact));
    EXPECT_LT(vir_test::ate(biased, fly(biased)), 1.2 * without + 0.01) << "seed " << seed;
  }
}

}  // namespace
}  // namespace vir::estimator
