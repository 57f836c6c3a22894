/// Ranges between anchors, and several antennas on a robot.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "anchor_distances.h"
#include "odometry_range_driver.h"
#include "vir_test_noise.h"

namespace vir::estimator {
namespace {

using vir_test::drifting;
using vir_test::flightOf;
using vir_test::fly;
using vir_test::RangeRun;
using vir_test::rangesTo;
using vir_test::RangeWorld;

const std::vector<Vec3> kAnchors{{9, 7, 2.5}, {-8, 6, 1.2}, {-7, -8, 3.0}};

TEST(AnchorDistances, OneNumberForEachPairWhicheverMeasuredIt) {
  AnchorDistances d;
  for (int i = 0; i < 20; ++i) {
    const bool outlier = i % 7 == 3;
    EXPECT_TRUE(d.add({i, 4, 2, outlier ? 9.0 : 5.0 + 0.01 * (i % 3), 0.1}, 0.5, 100));
    EXPECT_TRUE(d.add({i, 2, 4, 5.01, 0.1}, 0.5, 100));
  }
  EXPECT_EQ(d.pairs().size(), 1u);
  const auto known = d.of({2, 4});
  ASSERT_TRUE(known);
  EXPECT_NEAR(known->range_m, 5.01, 0.005);
  EXPECT_NEAR(known->sigma_m, 0.1 / 4, 1e-9) << "no better than of 16";
  EXPECT_FALSE(d.of({2, 5}));
  d.forget(4);
  EXPECT_TRUE(d.pairs().empty());
}

TEST(AnchorDistances, WhatCannotBeIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  AnchorDistances d;
  for (const double range : {nan, -1.0, 0.0, 1e9, std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(d.add({1, 1, 2, range, 0.1}, 0.5, 100)) << range;
  }
  EXPECT_FALSE(d.add({1, 2, 2, 5, 0.1}, 0.5, 100));
  EXPECT_FALSE(d.add({1, 1ull << 40, 2, 5, 0.1}, 0.5, 100));
  EXPECT_FALSE(d.add({1, 1, 2, 5, nan}, 0.5, 100));
  EXPECT_TRUE(d.pairs().empty());
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(d.add({i, 1, 2, 5, 0}, 0.5, 100));
  EXPECT_FALSE(d.of({1, 2})) << "too few";
}

/// RMS error of the anchors' positions at the end; with what they measure to each other, or not.
double anchorError(const RangeWorld& world, bool between) {
  OdometryRangeConfig config;
  config.ranges.uncalibrated_bias_sigma_m = 0;
  OdometryRangeEstimator estimator(config);
  test::Noise noise(7);
  std::size_t next = 0;
  for (const StampedPose& p : world.odometry) {
    for (; next < world.ranges.size() && world.ranges[next].t <= p.t; ++next) {
      estimator.addRange(world.ranges[next]);
    }
    for (std::uint64_t a = 0; between && a < kAnchors.size(); ++a) {
      const std::uint64_t b = (a + 1) % kAnchors.size();
      const double d = (kAnchors[a] - kAnchors[b]).norm() + 0.05 * noise.normal();
      estimator.addAnchorRange({p.t, a, b, d, 0.05});
    }
    estimator.addOdometry(p.t, p.T_W_B);
  }
  double sum = 0;
  for (const Anchor& a : estimator.anchors()) {
    EXPECT_TRUE(a.has_position);
    sum += (a.p_W - world.anchor(static_cast<std::size_t>(a.id))).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(kAnchors.size()));
}

TEST(AnchorRanges, TieAnchorsToOneAnother) {
  double with = 0, without = 0;
  for (int seed = 1; seed <= 4; ++seed) {
    const RangeWorld world(simulation::flight("eight", flightOf(25, seed)), drifting(seed),
                           rangesTo(kAnchors, seed));
    with += anchorError(world, true);
    without += anchorError(world, false);
  }
  EXPECT_LT(with, 0.85 * without);
}

/// Ranges of two antennas, 0.8 m to the left and to the right, at the same times.
std::vector<Range> ofTwo(const RangeWorld& left, const RangeWorld& right) {
  std::vector<Range> out;
  for (std::size_t i = 0; i < left.ranges.size() && i < right.ranges.size(); ++i) {
    EXPECT_EQ(left.ranges[i].t, right.ranges[i].t);
    out.push_back(left.ranges[i]);
    out.push_back(right.ranges[i]);
  }
  return out;
}

/// RMS error of the heading against the truth [rad], in W.
double headingError(const RangeWorld& world, const RangeRun& run) {
  double sum = 0;
  for (const StateEstimate& e : run.estimates) {
    const double off = yawOf(e.state.T_W_B.R()) - yawOf(world.truth(e.state.t).R());
    sum += std::pow(std::remainder(off, 2 * M_PI), 2);
  }
  return std::sqrt(sum / static_cast<double>(run.estimates.size()));
}

TEST(SeveralAntennas, BothCountAndTellTheHeading) {
  double with = 0, without = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    simulation::OdometrySimulationOptions drift = drifting(seed);
    drift.yaw_walk = 0.05;
    simulation::RangeSimulationOptions ranges = rangesTo(kAnchors, seed);
    ranges.lever_arm_m = {0, 0.8, 0.1};
    const simulation::Motion motion = simulation::flight("eight", flightOf(60, seed));
    const RangeWorld left(motion, drift, ranges);
    ranges.lever_arm_m = {0, -0.8, 0.1};
    const RangeWorld right(motion, drift, ranges);
    const std::vector<Range> both = ofTwo(left, right);
    OdometryRangeConfig config;
    config.odometry.noise.yaw_per_sqrt_m = 0.05;
    const RangeRun one = fly(left, config), two = fly(left, config, both);
    EXPECT_EQ(two.count(RangeDecision::repeated), 0);
    EXPECT_GT(two.count(RangeDecision::accepted), 1.5 * one.count(RangeDecision::accepted));
    with += headingError(left, two);
    without += headingError(left, one);
  }
  EXPECT_LT(with, 0.8 * without);
}

}  // namespace
}  // namespace vir::estimator
