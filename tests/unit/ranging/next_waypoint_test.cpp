#include "vir/ranging/next_waypoint.h"

#include <gtest/gtest.h>

#include <limits>

namespace vir::ranging {
namespace {

const Mat3 kCentimetre = Mat3::Identity() * 1e-4;

TEST(NextWaypoint, ChangesHeightWhereTwoHeightsAreOpen) {
  const std::vector<AnchorHypothesis> mirrored{{{3, 0, 1.5}, kCentimetre},
                                               {{3, 0, -1.5}, kCentimetre}};
  const auto way = nextWaypoint(Vec3::Zero(), mirrored, 0.3);
  ASSERT_TRUE(way);
  // Distances change by +-z d / r = 0.45 d: 0.22 m for half a metre, 0.45 m for one.
  EXPECT_NEAR((way->step_W - Vec3(0, 0, 1)).norm(), 0, 1e-12);
  EXPECT_NEAR(way->told_m, (std::hypot(3, 2.5) - std::hypot(3, 0.5)) / 2, 1e-2);
}

TEST(NextWaypoint, MovesSidewaysWhereARingIsOpenAndNeverAlongTheLine) {
  // A path along x leaves a circle around it: 4 m to the left, or to the right.
  const std::vector<AnchorHypothesis> ring{{{0, 4, 0}, kCentimetre}, {{0, -4, 0}, kCentimetre}};
  const auto way = nextWaypoint(Vec3::Zero(), ring, 0.3);
  ASSERT_TRUE(way);
  EXPECT_NEAR(way->step_W.x(), 0, 1e-9);
  EXPECT_NEAR(way->step_W.z(), 0, 1e-9);
  EXPECT_NEAR(std::abs(way->step_W.y()), 0.5, 1e-9);
  EXPECT_NEAR(way->told_m, 0.5, 1e-2);
}

TEST(NextWaypoint, GoesAcrossTheLineOfSightWhereOnePositionIsVague) {
  Mat3 wide = kCentimetre;
  wide(1, 1) = 4;  // two metres along y, ten metres away along x
  const auto way = nextWaypoint(Vec3::Zero(), {{{10, 0, 0}, wide}}, 0.3);
  ASSERT_TRUE(way);
  EXPECT_GT(std::abs(way->step_W.y()), 0.7 * way->step_W.norm());
  EXPECT_GE(way->told_m, 0.3);
  // By a third of the points, one sigma sqrt(3) aside each way: 2 m / 10 m of the step.
  EXPECT_NEAR(way->told_m, std::abs(way->step_W.y()) * 0.2, 0.1 * way->told_m);
}

TEST(NextWaypoint, SaysNothingWhereNothingIsToBeTold) {
  EXPECT_FALSE(nextWaypoint(Vec3::Zero(), {{{3, 0, 1}, kCentimetre}}, 0.3));
  EXPECT_FALSE(nextWaypoint(Vec3::Zero(), {}, 0.3));
  // What is open along the line of sight only is measured.
  Mat3 along = kCentimetre;
  along(0, 0) = 100;
  EXPECT_FALSE(nextWaypoint(Vec3::Zero(), {{{30, 0, 0}, along}}, 0.3));
}

TEST(NextWaypoint, SendsNobodyIntoTheFloor) {
  // Above the robot going down tells as much as going up, and more where the anchors are lower.
  const std::vector<AnchorHypothesis> below{{{3, 0, -0.3}, kCentimetre},
                                            {{3, 0, -2.5}, kCentimetre}};
  const auto free = nextWaypoint(Vec3::Zero(), below, 0.3);
  ASSERT_TRUE(free);
  EXPECT_LT(free->step_W.z(), 0);
  const auto floor = nextWaypoint(Vec3::Zero(), below, 0.3, 0);
  ASSERT_TRUE(floor);
  EXPECT_GE(floor->step_W.z(), 0);
}

TEST(NextWaypoint, TakesAnyNumbers) {
  const double bad[] = {0,
                        1e-300,
                        1e18,
                        1e308,
                        std::numeric_limits<double>::infinity(),
                        std::numeric_limits<double>::quiet_NaN()};
  for (const double v : bad) {
    for (const double w : bad) {
      const auto way = nextWaypoint(Vec3(v, 0, 0), {{Vec3(0, w, 1), Mat3::Identity() * v}}, w);
      if (!way) continue;
      EXPECT_TRUE(way->step_W.allFinite());
      EXPECT_LE(way->step_W.norm(), 8.001);
    }
  }
}

}  // namespace
}  // namespace vir::ranging
