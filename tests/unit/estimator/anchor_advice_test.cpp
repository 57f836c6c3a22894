/// What is said of anchors is of use, and is taken back where it no longer holds.
#include <gtest/gtest.h>

#include <set>

#include "odometry_range_driver.h"

namespace vir::estimator {
namespace {

using vir_test::drifting;
using vir_test::flightOf;
using vir_test::fly;
using vir_test::RangeRun;
using vir_test::rangesTo;
using vir_test::RangeWorld;

const Vec3 kAnchor(5, 4, 2.5);

/// Ranges that are merged at rest: waiting brings no more of them.
TEST(AnchorAdvice, AtRestNobodyIsToldToWait) {
  simulation::FlightOptions o = flightOf(20);
  o.rest_s = 20;
  simulation::OdometrySimulationOptions wheels;  // that stand still when the robot does
  wheels.yaw_walk = wheels.position_walk = 0;
  const RangeWorld world(simulation::flight("eight", o), wheels, rangesTo({kAnchor}));
  std::set<std::string> at_rest;
  fly(world, {}, [&](const OdometryRangeEstimator& estimator, const StateEstimate& now) {
    if (now.state.t < world.time(8) || now.state.t > world.time(19)) return;
    for (const Anchor& a : estimator.anchors()) {
      if (at_rest.insert(a.advice).second) std::printf("%s\n", a.advice.c_str());
    }
  });
  ASSERT_FALSE(at_rest.empty());
  for (const std::string& advice : at_rest) {
    EXPECT_EQ(advice.find("wait"), std::string::npos) << advice;
    EXPECT_EQ(advice.rfind("move further", 0), 0u) << advice;
  }
}

/// From when it is noticed until it is found again.
TEST(AnchorAdvice, AnAnchorThatWasMovedHasAdvice) {
  simulation::RangeSimulationOptions ranges = rangesTo({kAnchor});
  ranges.jump = {0, 70, -5, -5, 1.5};
  const RangeWorld world(simulation::flight("eight", flightOf(160)), drifting(), ranges);
  long moved = 0, silent = 0;
  const RangeRun run =
      fly(world, {}, [&](const OdometryRangeEstimator& estimator, const StateEstimate&) {
        for (const Anchor& a : estimator.anchors()) {
          if (a.state != AnchorState::moved) continue;
          ++moved;
          silent += a.advice.empty() ? 1 : 0;
        }
      });
  EXPECT_TRUE(run.warned("it has been moved"));
  EXPECT_GT(moved, 5);
  EXPECT_EQ(silent, 0);
}

/// Too long by 0.4 m until `until_s`, as behind an obstacle.
RangeRun flyWithLongRanges(int seed, double until_s) {
  const RangeWorld world(simulation::flight("eight", flightOf(160, seed)), drifting(seed),
                         rangesTo({kAnchor}, seed));
  std::vector<Range> all = world.ranges;
  for (Range& r : all) {
    if (r.t < world.time(until_s)) r.range_m += 0.4;
  }
  return fly(world, {}, all);
}

TEST(AnchorAdvice, ABoardThatOnlySeemedUncalibratedIsTakenBack) {
  int said = 0, taken_back = 0, said_of_true = 0, taken_back_of_true = 0;
  for (int seed = 1; seed <= 6; ++seed) {
    const RangeRun seemed = flyWithLongRanges(seed, 25), is = flyWithLongRanges(seed, 1e4);
    said += seemed.warned("an uncalibrated board");
    taken_back += seemed.warned("right after all");
    said_of_true += is.warned("an uncalibrated board");
    taken_back_of_true += is.warned("right after all");
    std::printf("seed %d: bias %.3f, %.3f m\n", seed, seemed.anchors[0].bias_m,
                is.anchors[0].bias_m);
  }
  std::printf("%d said, %d taken back; of true ones %d and %d\n", said, taken_back, said_of_true,
              taken_back_of_true);
  EXPECT_GE(said, 3);
  EXPECT_EQ(taken_back, said);
  EXPECT_GE(said_of_true, 3);
  EXPECT_EQ(taken_back_of_true, 0);
}

}  // namespace
}  // namespace vir::estimator
