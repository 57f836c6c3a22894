#include "vir/ranging/range_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "vir_test_noise.h"

namespace {

using vir::RangeDecision;
using vir::TimeNs;
using vir::ranging::RangeGate;
constexpr TimeNs kStep = 50'000'000;  // 20 Hz

struct Outcome {
  int accepted = 0, suspicious_at = -1;
};

/// `n` ranges with the residuals and the sigma given; the antenna moves 0.05 m per range.
Outcome feed(RangeGate* gate, int from, int n, double sigma,
             const std::function<double(int)>& residual, double speed = 0.05) {
  Outcome o;
  for (int i = from; i < from + n; ++i) {
    const auto d = gate->check(i * kStep, residual(i), sigma * sigma, speed * i);
    if (d == RangeDecision::accepted) ++o.accepted;
    if (gate->suspicious() && o.suspicious_at < 0) o.suspicious_at = i - from;
  }
  return o;
}

TEST(RangeGate, GoodRangesPassAndAreNotSuspicious) {
  vir::test::Noise noise(1);
  RangeGate gate;
  const Outcome o = feed(&gate, 0, 5000, 0.1, [&](int) { return 0.1 * noise.normal(); });
  EXPECT_GE(o.accepted, 4995);
  EXPECT_EQ(o.suspicious_at, -1);
  EXPECT_EQ(gate.counters().widened, 0);
}

TEST(RangeGate, SaysOnWhichSide) {
  RangeGate gate;
  EXPECT_EQ(gate.check(0, 1.0, 0.01), RangeDecision::too_long);
  EXPECT_EQ(gate.check(1, -1.0, 0.01), RangeDecision::too_short);
  EXPECT_EQ(gate.check(2, 0.3, 0.01), RangeDecision::accepted);
  EXPECT_EQ(gate.counters().too_long, 1);
  EXPECT_EQ(gate.counters().too_short, 1);
}

TEST(RangeGate, ScatteredOutliersStayOut) {
  vir::test::Noise noise(2);
  RangeGate gate;
  int let_in = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool outlier = noise.uniform() < 0.3;
    const double r = 0.1 * noise.normal() + (outlier ? 0.6 + 1.2 * noise.uniform() : 0.0);
    if (gate.check(i * kStep, r, 0.01) == RangeDecision::accepted && outlier) ++let_in;
    EXPECT_FALSE(gate.suspicious());
  }
  EXPECT_LT(let_in, 60);  // of 1200; those that are within 4 sigma by chance
}

TEST(RangeGate, ABurstWithoutLineOfSightStaysOut) {
  vir::test::Noise noise(3);
  RangeGate gate;
  feed(&gate, 0, 400, 0.1, [&](int) { return 0.1 * noise.normal(); });
  // 6 s, growing slowly: consistent with itself.
  const Outcome burst = feed(&gate, 400, 120, 0.1,
                             [&](int i) { return 0.8 + 0.005 * (i - 400) + 0.1 * noise.normal(); });
  EXPECT_EQ(burst.accepted, 0);
  EXPECT_EQ(burst.suspicious_at, -1);
  const Outcome after = feed(&gate, 520, 400, 0.1, [&](int) { return 0.1 * noise.normal(); });
  EXPECT_GE(after.accepted, 398);
}

TEST(RangeGate, ACovarianceTooSmallOpensTheGate) {
  vir::test::Noise noise(4);
  // Claimed 0.03 m, in truth 0.3 m and both ways.
  RangeGate gate;
  feed(&gate, 0, 200, 0.03, [&](int) { return 0.3 * noise.normal(); });
  const Outcome o = feed(&gate, 200, 1000, 0.03, [&](int) { return 0.3 * noise.normal(); });
  EXPECT_GT(o.accepted, 900);
  EXPECT_EQ(o.suspicious_at, -1);
}

TEST(RangeGate, AnErrorThatBuildsUpIsLetInWithinSeconds) {
  // We are 0.25 m off and sure to 0.02 m: the ranges are too short throughout.
  RangeGate gate;
  feed(&gate, 0, 400, 0.02, [](int) { return 0.01; });
  const Outcome o = feed(&gate, 400, 200, 0.02, [](int i) { return -0.25 + 0.01 * (i % 3); });
  EXPECT_GT(o.accepted, 120);
  EXPECT_EQ(o.suspicious_at, -1);
}

TEST(RangeGate, AMovedAnchorIsNoticed) {
  for (const double sign : {1.0, -1.0}) {
    vir::test::Noise noise(5);
    RangeGate gate;
    feed(&gate, 0, 400, 0.1, [&](int) { return 0.1 * noise.normal(); });
    const auto moved = [&](int i) {
      return sign * (2.5 + std::sin(0.02 * i)) + 0.1 * noise.normal();
    };
    const Outcome o = feed(&gate, 400, 1000, 0.1, moved);
    ASSERT_GE(o.suspicious_at, 0) << sign;
    // Four fifths of 3 s where it cannot be an obstacle; where it can, of 25 s, during which the
    // gate opens and lets some in: then of twice that.
    if (sign < 0) {
      EXPECT_NEAR(o.suspicious_at, 48, 10);
    } else {
      EXPECT_GT(o.suspicious_at, 380);
      EXPECT_LT(o.suspicious_at, 820);
    }
    gate.reset();
    EXPECT_FALSE(gate.suspicious());
    EXPECT_EQ(gate.check(1400 * kStep, 0.0, 0.01), RangeDecision::accepted);
  }
}

TEST(RangeGate, AMovedAnchorWithinTheWidenedGateIsNoticedToo) {
  RangeGate gate;
  feed(&gate, 0, 400, 0.1, [](int) { return 0.05; });
  const Outcome o =
      feed(&gate, 400, 800, 0.1, [](int i) { return -0.8 + 0.1 * std::sin(0.05 * i); });
  EXPECT_GT(o.suspicious_at, 0);
}

TEST(RangeGate, StandingBehindAnObstacleIsNoMovedAnchor) {
  vir::test::Noise noise(6);
  RangeGate gate;
  const Outcome o = feed(
      &gate, 0, 2000, 0.1, [&](int) { return 2.5 + 0.1 * noise.normal(); }, 0.0);
  EXPECT_EQ(o.suspicious_at, -1);
}

TEST(RangeGate, ABrokenDeviceIsNoMovedAnchor) {
  vir::test::Noise noise(7);
  RangeGate gate;
  const Outcome o = feed(&gate, 0, 2000, 0.1, [&](int) { return 40 * (noise.uniform() - 0.5); });
  EXPECT_EQ(o.suspicious_at, -1);
  EXPECT_LT(o.accepted, 300);
}

TEST(RangeGate, NumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  RangeGate gate;
  EXPECT_EQ(gate.check(0, nan, 0.01), RangeDecision::invalid);
  EXPECT_EQ(gate.check(1, inf, 0.01), RangeDecision::invalid);
  EXPECT_EQ(gate.check(2, 0.0, 0.0), RangeDecision::accepted);  // standstill: 0/0
  EXPECT_EQ(gate.check(3, 0.5, nan), RangeDecision::accepted);
  EXPECT_EQ(gate.check(4, 0.5, -1.0), RangeDecision::accepted);
  EXPECT_EQ(gate.check(5, 50.0, nan), RangeDecision::too_long);
  EXPECT_EQ(gate.check(6, 1e300, inf), RangeDecision::accepted);
  EXPECT_EQ(gate.check(7, 1e300, 1e-300), RangeDecision::too_long);
  EXPECT_EQ(gate.counters().invalid, 2);
  EXPECT_FALSE(gate.suspicious());
}

TEST(RangeGate, HolesAndStepsOfTheClock) {
  RangeGate gate;
  feed(&gate, 0, 300, 0.1, [](int i) { return i % 2 ? 1.0 : -1.0; });
  EXPECT_EQ(gate.check(300 * kStep + 60'000'000'000, 0.1, 0.01), RangeDecision::accepted);
  EXPECT_FALSE(gate.suspicious());
  EXPECT_EQ(gate.check(0, 0.1, 0.01), RangeDecision::accepted);
  EXPECT_EQ(gate.check(kStep, -0.45, 0.01), RangeDecision::too_short) << "the past is forgotten";
}

}  // namespace
