#include "vir/ranging/range_check.h"

#include <gtest/gtest.h>

#include <limits>

namespace {

using vir::RangeDecision;
using vir::ranging::RangeCheck;
constexpr vir::TimeNs kStep = 50'000'000;

TEST(RangeCheck, ValuesThatAreNoDistance) {
  RangeCheck check;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(check.check(1, 0, nan), RangeDecision::not_finite);
  EXPECT_EQ(check.check(1, 0, -inf), RangeDecision::not_finite);
  EXPECT_EQ(check.check(1, 0, -0.3), RangeDecision::negative);
  EXPECT_EQ(check.check(1, 0, 0.0), RangeDecision::zero);
  EXPECT_EQ(check.check(1, 0, 65535.0), RangeDecision::too_far);
  // None of them has used up the stamp.
  EXPECT_EQ(check.check(1, 0, 3.0), RangeDecision::accepted);
  EXPECT_EQ(check.counters().ok, 1);
  EXPECT_EQ(check.counters().rejected(), 5);
  EXPECT_EQ(check.counters().text(), "2 not_finite, 1 negative, 1 zero, 1 too_far");
}

TEST(RangeCheck, TimesAreCheckedPerAnchor) {
  RangeCheck check;
  EXPECT_EQ(check.check(1, 10 * kStep, 3.0), RangeDecision::accepted);
  EXPECT_EQ(check.check(2, 9 * kStep, 3.0), RangeDecision::accepted);
  EXPECT_EQ(check.check(1, 10 * kStep, 3.0), RangeDecision::repeated);
  EXPECT_EQ(check.check(1, 9 * kStep, 3.1), RangeDecision::out_of_order);
  EXPECT_EQ(check.check(2, 10 * kStep, 3.1), RangeDecision::accepted);
  EXPECT_EQ(check.counters(1).rejected(), 2);
  EXPECT_EQ(check.counters(2).rejected(), 0);
  EXPECT_EQ(check.counters(3).ok, 0);
}

TEST(RangeCheck, AClockSetBackIsNoReasonToRejectForEver) {
  RangeCheck check;
  check.check(1, 1000 * kStep, 3.0);
  int rejected = 0;
  for (int i = 0; i < 100; ++i) {
    if (check.check(1, i * kStep, 3.0 + 0.01 * i) != RangeDecision::accepted) ++rejected;
  }
  EXPECT_EQ(rejected, 20);
  EXPECT_EQ(check.counters().clock_restarts, 1);
}

TEST(RangeCheck, LateRangesInBetweenDoNotMoveTheClock) {
  RangeCheck check;
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(check.check(1, (10 + i) * kStep, 3.0 + 0.01 * i), RangeDecision::accepted);
    EXPECT_EQ(check.check(1, i * kStep, 3.0 + 0.01 * i), RangeDecision::out_of_order);
  }
  EXPECT_EQ(check.counters().clock_restarts, 0);
}

TEST(RangeCheck, AStuckDevice) {
  RangeCheck check;
  for (int i = 0; i < 50; ++i) EXPECT_EQ(check.check(1, i * kStep, 4.21), RangeDecision::accepted);
  EXPECT_EQ(check.check(1, 50 * kStep, 4.21), RangeDecision::stuck);
  EXPECT_EQ(check.check(1, 51 * kStep, 4.22), RangeDecision::accepted);
  EXPECT_EQ(check.check(1, 52 * kStep, 4.21), RangeDecision::accepted);
}

TEST(RangeCheck, RandomIdsDoNotFillTheMemory) {
  RangeCheck check;
  for (int id = 0; id < 300; ++id) check.check(id, 0, 1.0);
  EXPECT_EQ(check.counters().problems.at(RangeDecision::too_many_anchors), 44);
  EXPECT_EQ(check.check(3, kStep, 1.0), RangeDecision::accepted);
}

}  // namespace
