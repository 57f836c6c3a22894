/// A reference that is somewhere else for a moment spoils no comparison, and is told of.
#include "vir/evaluation/leaps.h"

#include <gtest/gtest.h>

#include <limits>

#include "made_trajectories.h"
#include "vir/evaluation/evaluate.h"

namespace vir::evaluation {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

long leftOut(const Trajectory& trajectory) {
  long out = 0;
  withoutLeaps(trajectory, &out);
  return out;
}

/// Along x with a speed of its own for every second; 100 Hz.
Trajectory driven(const std::vector<double>& speeds) {
  Trajectory out;
  double x = 0;
  for (const double v : speeds) {
    for (int i = 0; i < 100; ++i, x += 0.01 * v) {
      const TimeNs t = 10'000'000 * static_cast<TimeNs>(out.size());
      out.push_back({t, Pose(Quat::Identity(), Vec3(x, 0, 0))});
    }
  }
  return out;
}

TEST(Leaps, OnePoseThatCannotBe) {
  const Trajectory truth = test::winding(10, 100);
  for (const double far : {10.0, 1e6, -1e6, 1e100, 1e308, kNan, kInfinite}) {
    for (const std::size_t at :
         {std::size_t(0), std::size_t(1), std::size_t(500), truth.size() - 1}) {
      Trajectory bad = truth;
      bad[at].T_W_B.p.y() = far;
      long left_out = 0;
      const Trajectory kept = withoutLeaps(bad, &left_out);
      EXPECT_EQ(left_out, 1) << far << " at " << at;
      ASSERT_EQ(kept.size(), truth.size() - 1);
      for (const StampedPose& p : kept) EXPECT_NE(p.t, truth[at].t);
      const EvaluationResult result = evaluate(bad, truth, {});
      EXPECT_EQ(result.reference_left_out, 1);
      EXPECT_LT(result.ate_position_m.max, 1e-3) << far << " at " << at;
    }
  }
}

/// Second for second at the origin of the tracker, far from the robot.
TEST(Leaps, StretchesElsewhere) {
  Trajectory bad = test::winding(20, 100);
  for (StampedPose& p : bad) p.T_W_B.p.x() += 300;
  for (std::size_t i = 200; i < 300; ++i) bad[i].T_W_B.p.setZero();
  for (std::size_t i = 1500; i < 1800; ++i) bad[i].T_W_B.p.setZero();
  EXPECT_EQ(leftOut(bad), 400);
}

TEST(Leaps, WhatMovesIsNoLeap) {
  EXPECT_EQ(leftOut({}), 0);
  EXPECT_EQ(leftOut({{5, Pose()}}), 0);
  EXPECT_EQ(leftOut(test::winding(60, 200)), 0);
  EXPECT_EQ(leftOut(driven({0, 0, 0, 20, 60, 120, 250, 250, 300, 100, 0, 0})), 0);
  EXPECT_EQ(leftOut(driven({7000, 7000, 7000})), 0);
  // Five centimetres of noise at 200 Hz are 10 m/s; a tracker that corrects itself by half a metre.
  Trajectory noisy = test::noisy(test::winding(20, 200), 0.05, 0.01, 3);
  for (std::size_t i = 2000; i < noisy.size(); ++i) noisy[i].T_W_B.p.x() += 0.5;
  EXPECT_EQ(leftOut(noisy), 0);
}

/// A hole in the reference during which the robot went far.
TEST(Leaps, WhatTimeAllowsIsNoLeap) {
  Trajectory truth = test::winding(10, 100);
  const Trajectory later = test::winding(10, 100, truth.back().t + 10'000'000'000);
  for (const StampedPose& p : later)
    truth.push_back({p.t, Pose(p.T_W_B.q, p.T_W_B.p + Vec3(500, 0, 0))});
  EXPECT_EQ(leftOut(truth), 0);
}

TEST(Leaps, StampsAnywhere) {
  Trajectory truth{{INT64_MIN, Pose()}, {0, Pose()}, {1, Pose()},
                   {2, Pose()},         {3, Pose()}, {INT64_MAX, Pose()}};
  EXPECT_EQ(leftOut(truth), 0);
  truth[2].T_W_B.p.x() = 1e308;
  EXPECT_EQ(leftOut(truth), 1);
}

}  // namespace
}  // namespace vir::evaluation
