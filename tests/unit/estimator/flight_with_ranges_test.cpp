/// Whole flights with a camera (simulated tracks), an IMU and ranges: what a wrong start of an
/// anchor does, and whether the covariances hold.
#include <gtest/gtest.h>

#include "looking_ahead.h"

namespace vir::estimator {
namespace {

using tool::RunResult;
using tool::RunSettings;
using tool::simulateRun;
using vir_test::flightOf;

/// With one anchor.
RunSettings lookingAhead(const Vec3& anchor_from_start, const simulation::Motion& motion) {
  RunSettings s = vir_test::lookingAhead();
  const Vec3 at = motion.poseAt(motion.begin()).p + anchor_from_start;
  s.ranges.anchor_m.assign(at.data(), at.data() + 3);
  s.use_ranges = true;
  return s;
}

/// Straight towards an anchor that stands a little beside the path: the first ranges leave a valley
/// of positions, and a position a metre or two off must neither stay nor bend the odometry. These
/// seeds were lost by tens of metres while an anchor kept the place where it was first found.
TEST(FlightWithRanges, AnAnchorFirstFoundInTheWrongPlace) {
  const auto motion = flightOf("corridor", 40);
  for (const int seed : {4, 5, 9}) {
    const RunResult run = simulateRun(motion, lookingAhead(Vec3(10, 3, 1), *motion), seed);
    ASSERT_TRUE(run.valid);
    EXPECT_EQ(run.resets, 0);
    EXPECT_LT(run.evaluation.ate_position_m.max, 0.7) << "seed " << seed;
    ASSERT_EQ(run.anchors.size(), 1u);
    EXPECT_TRUE(run.anchors[0].found);
    EXPECT_LT(run.anchors[0].horizontal_m, 0.3) << "seed " << seed;
  }
}

/// Measured over 20 seeds of 120 m: 0.038 m with and 0.084 m without ranges, NEES per dimension 1.3
/// of the position and 0.8 of the anchor.
TEST(FlightWithRanges, RangesTakeDriftAwayAndCovariancesHold) {
  const auto motion = flightOf("eight", 80);
  double with = 0, without = 0, smoothed_with = 0, smoothed_without = 0, position = 0, anchor = 0;
  const int runs = 3;
  for (int seed = 1; seed <= runs; ++seed) {
    RunSettings s = lookingAhead(Vec3(4, 3, 1), *motion);
    const RunResult on = simulateRun(motion, s, seed);
    s.use_ranges = false;
    const RunResult off = simulateRun(motion, s, seed);
    ASSERT_TRUE(on.valid && off.valid);
    with += on.evaluation.ate_position_m.rmse / runs;
    without += off.evaluation.ate_position_m.rmse / runs;
    smoothed_with += on.smoothed_ate_m / runs;
    smoothed_without += off.smoothed_ate_m / runs;
    position += on.mean_nees / 3 / runs;
    ASSERT_TRUE(on.anchors.at(0).found);
    anchor += on.anchors[0].nees / 3 / runs;
  }
  std::printf("causal %.3f m, without ranges %.3f m; smoothed %.3f m, %.3f m; NEES %.2f, %.2f\n",
              with, without, smoothed_with, smoothed_without, position, anchor);
  EXPECT_LT(with, 0.9 * without);
  EXPECT_LT(smoothed_with, 0.65 * smoothed_without);
  // Of few runs the mean scatters: the bounds are wider than those of many.
  EXPECT_GT(position, 0.3);
  EXPECT_LT(position, 2.5);
  EXPECT_LT(anchor, 2.5);
}

}  // namespace
}  // namespace vir::estimator
