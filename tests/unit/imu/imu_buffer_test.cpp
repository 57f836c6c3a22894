#include "vir/imu/imu_buffer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace vir::imu {
namespace {

constexpr TimeNs kMs = 1000000;
const Vec3 kZero = Vec3::Zero();

ImuSample at(TimeNs t, const Vec3& gyro, const Vec3& acc) { return {t, gyro, acc}; }

/// Readings every 5 ms whose acceleration along x grows linearly, 1 m/s^2 per second.
ImuBuffer ramp(TimeNs from, TimeNs to) {
  ImuBuffer b;
  for (TimeNs t = from; t <= to; t += 5 * kMs) b.add(at(t, kZero, Vec3(toSeconds(t), 0, 0)));
  return b;
}

TEST(ImuBuffer, InterpolatesAtBothEnds) {
  ImuBuffer b = ramp(0, 1000 * kMs);
  bool gap = true;
  // From 0.1015 s to 0.8985 s, neither on a reading: v = integral of t dt = (0.8985^2-0.1015^2)/2.
  const Preintegration p = b.integrate(101500000, 898500000, ImuNoise(), kZero, kZero, &gap);
  EXPECT_NEAR(p.dt(), 0.797, 1e-12);
  EXPECT_NEAR(p.dv().x(), 0.5 * (0.8985 * 0.8985 - 0.1015 * 0.1015), 1e-12);
  EXPECT_FALSE(gap);
}

TEST(ImuBuffer, AdjacentIntervalsMakeTheWhole) {
  ImuBuffer b = ramp(0, 1000 * kMs);
  Preintegration first = b.integrate(3 * kMs, 333 * kMs, ImuNoise(), kZero, kZero);
  first.append(b.integrate(333 * kMs, 990 * kMs, ImuNoise(), kZero, kZero));
  const Preintegration whole = b.integrate(3 * kMs, 990 * kMs, ImuNoise(), kZero, kZero);
  EXPECT_NEAR(first.dv().x(), whole.dv().x(), 1e-12);
  EXPECT_NEAR(first.dt(), whole.dt(), 1e-12);
}

TEST(ImuBuffer, ReadingsAtTheEndOfTheRangeAreAsUncertainAsAGap) {
  ImuBuffer b;
  for (int k = 0; k < 200; ++k) {
    const double t = 0.005 * k;
    // Between 0.40 and 0.45 s the rate is beyond 4 rad/s.
    const bool beyond = k >= 80 && k <= 90;
    b.add(at(5 * kMs * k, Vec3(beyond ? 4.0 : 1 + 0.1 * std::sin(30 * t), 0.1 * std::sin(9 * t), 0),
             Vec3(0, 0.3 * std::cos(7 * t), 9.81)));
  }
  const auto sigma = [&](TimeNs t0, TimeNs t1) {
    bool gap = true;
    const Preintegration p = b.integrate(t0, t1, ImuNoise(), kZero, kZero, &gap);
    EXPECT_FALSE(gap) << "nothing is missing";
    return std::sqrt(p.covariance()(kTheta, kTheta));
  };
  const double before = sigma(300 * kMs, 350 * kMs);
  EXPECT_NEAR(sigma(600 * kMs, 650 * kMs), before, 1e-3 * before);
  EXPECT_NEAR(sigma(400 * kMs, 450 * kMs), 150 * before, 1.5 * before);
  b.dropBefore(500 * kMs);
  EXPECT_NEAR(sigma(600 * kMs, 650 * kMs), before, 1e-3 * before) << "forgotten";
}

TEST(ImuBuffer, NoReadingBetweenTwoImages) {
  ImuBuffer b = ramp(0, 1000 * kMs);
  // Both times lie between the readings at 100 and 105 ms: v = 0.002 s * 0.102 m/s^2.
  bool gap = true;
  const Preintegration p = b.integrate(101 * kMs, 103 * kMs, ImuNoise(), kZero, kZero, &gap);
  EXPECT_EQ(p.size(), 1u);
  EXPECT_NEAR(p.dv().x(), 0.002 * 0.102, 1e-15);
  EXPECT_FALSE(gap);
  EXPECT_NO_THROW(p.sqrtInformation());
}

TEST(ImuBuffer, TimesOnReadingsAndOneNanosecondApart) {
  ImuBuffer b = ramp(0, 100 * kMs);
  EXPECT_NEAR(b.integrate(0, 100 * kMs, ImuNoise(), kZero, kZero).dv().x(), 0.005, 1e-14);
  const Preintegration p = b.integrate(50 * kMs, 50 * kMs + 1, ImuNoise(), kZero, kZero);
  EXPECT_NEAR(p.dt(), 1e-9, 1e-20);
  EXPECT_TRUE(p.covariance().allFinite());
}

TEST(ImuBuffer, DropsAndCountsWhatIsOutOfOrderRepeatedOrNotFinite) {
  ImuBuffer b;
  EXPECT_TRUE(b.add(at(10 * kMs, kZero, kZero)));
  EXPECT_FALSE(b.add(at(10 * kMs, kZero, kZero)));  // repeated
  EXPECT_FALSE(b.add(at(5 * kMs, kZero, kZero)));   // from the past
  EXPECT_FALSE(b.add(at(15 * kMs, Vec3(NAN, 0, 0), kZero)));
  EXPECT_FALSE(b.add(at(15 * kMs, kZero, Vec3(0, 0, std::numeric_limits<double>::infinity()))));
  EXPECT_TRUE(b.add(at(15 * kMs, kZero, kZero)));
  EXPECT_EQ(b.counters().accepted, 2);
  EXPECT_EQ(b.counters().out_of_order, 2);
  EXPECT_EQ(b.counters().not_finite, 2);
  EXPECT_EQ(b.counters().gaps, 0);
  EXPECT_EQ(b.lastTime(), 15 * kMs);
}

TEST(ImuBuffer, GapIsBridgedCountedAndDistrusted) {
  ImuBuffer b;
  for (TimeNs t = 0; t <= 100 * kMs; t += 5 * kMs) b.add(at(t, kZero, Vec3(1, 0, 0)));
  for (TimeNs t = 600 * kMs; t <= 700 * kMs; t += 5 * kMs) b.add(at(t, kZero, Vec3(3, 0, 0)));
  EXPECT_EQ(b.counters().gaps, 1);
  bool gap = false;
  const Preintegration p = b.integrate(0, 700 * kMs, ImuNoise(), kZero, kZero, &gap);
  EXPECT_TRUE(gap);
  // 0.1 s at 1, 0.5 s at (1 + 3)/2, 0.1 s at 3 m/s^2.
  EXPECT_NEAR(p.dv().x(), 0.1 + 1.0 + 0.3, 1e-12);
  // What the gap hides: about 1 m/s^2 over half a second must be within the standard deviation.
  EXPECT_GT(std::sqrt(p.covariance()(kV, kV)), 0.3);
  // Parts of the gap are gaps; what lies beside it is not.
  b.integrate(200 * kMs, 300 * kMs, ImuNoise(), kZero, kZero, &gap);
  EXPECT_TRUE(gap);
  b.integrate(20 * kMs, 90 * kMs, ImuNoise(), kZero, kZero, &gap);
  EXPECT_FALSE(gap);
  b.integrate(610 * kMs, 700 * kMs, ImuNoise(), kZero, kZero, &gap);
  EXPECT_FALSE(gap);
}

TEST(ImuBuffer, KnowsItsHolesAsLongAsTheirReadings) {
  ImuBuffer b(0.05, 1.0);
  b.add(at(0, kZero, kZero));
  b.add(at(900 * kMs, kZero, kZero));   // a gap that can be bridged
  b.add(at(2000 * kMs, kZero, kZero));  // 1.1 s: a hole
  b.add(at(2010 * kMs, kZero, kZero));
  b.add(at(4000 * kMs, kZero, kZero));  // another
  EXPECT_EQ(b.counters().gaps, 3);
  EXPECT_EQ(b.counters().holes, 2);
  for (const int ms : {-5, 0, 450, 900, 2000, 2005, 2010, 4000, 4500}) {
    EXPECT_FALSE(b.inHole(ms * kMs)) << ms;
  }
  for (const int ms : {901, 1500, 1999, 2011, 3999}) EXPECT_TRUE(b.inHole(ms * kMs)) << ms;
  b.dropBefore(2005 * kMs);
  EXPECT_FALSE(b.inHole(1500 * kMs)) << "its readings are gone";
  EXPECT_TRUE(b.inHole(3000 * kMs));
  b.clear();
  EXPECT_FALSE(b.inHole(3000 * kMs));
  // The clock begins anew in the past: complete readings where a hole has been.
  for (TimeNs t = 1000 * kMs; t <= 3500 * kMs; t += 5 * kMs) b.add(at(t, kZero, kZero));
  EXPECT_FALSE(b.inHole(1500 * kMs));
  EXPECT_FALSE(b.inHole(3002 * kMs));
  EXPECT_EQ(b.counters().holes, 2);
}

TEST(ImuBuffer, OneReadingShortOfTheImage) {
  ImuBuffer b = ramp(0, 100 * kMs);
  EXPECT_TRUE(b.covers(100 * kMs));
  EXPECT_FALSE(b.covers(103 * kMs));
  bool gap = true;
  // The last reading is held for 3 ms: too short to distrust.
  const Preintegration p = b.integrate(50 * kMs, 103 * kMs, ImuNoise(), kZero, kZero, &gap);
  EXPECT_NEAR(p.dt(), 0.053, 1e-12);
  EXPECT_NEAR(p.dv().x(), 0.5 * (0.01 - 0.0025) + 0.003 * 0.1, 1e-12);
  EXPECT_FALSE(gap);
}

TEST(ImuBuffer, BeyondBothEndsTheNearestReadingIsHeld) {
  ImuBuffer b;
  for (TimeNs t = 1000 * kMs; t <= 1100 * kMs; t += 5 * kMs) b.add(at(t, kZero, Vec3(2, 0, 0)));
  bool gap = false;
  EXPECT_NEAR(b.integrate(0, 1050 * kMs, ImuNoise(), kZero, kZero, &gap).dv().x(), 2.1, 1e-12);
  EXPECT_TRUE(gap);
  EXPECT_NEAR(b.integrate(1050 * kMs, 2050 * kMs, ImuNoise(), kZero, kZero, &gap).dv().x(), 2,
              1e-12);
  EXPECT_TRUE(gap);
  // Wholly after, wholly before.
  EXPECT_NEAR(b.integrate(3000 * kMs, 3500 * kMs, ImuNoise(), kZero, kZero, &gap).dt(), 0.5, 1e-12);
  EXPECT_TRUE(gap);
  EXPECT_NEAR(b.integrate(0, 500 * kMs, ImuNoise(), kZero, kZero, &gap).dt(), 0.5, 1e-12);
  EXPECT_TRUE(gap);
}

TEST(ImuBuffer, RefusesWhatCannotBeIntegrated) {
  ImuBuffer empty;
  EXPECT_TRUE(empty.empty());
  EXPECT_FALSE(empty.covers(0));
  EXPECT_THROW(empty.integrate(0, 1, ImuNoise(), kZero, kZero), std::invalid_argument);
  ImuBuffer b = ramp(0, 100 * kMs);
  EXPECT_THROW(b.integrate(50, 50, ImuNoise(), kZero, kZero), std::invalid_argument);
  EXPECT_THROW(b.integrate(50, 40, ImuNoise(), kZero, kZero), std::invalid_argument);
}

TEST(ImuBuffer, DropBeforeKeepsTheReadingToInterpolateFrom) {
  ImuBuffer b = ramp(0, 1000 * kMs);
  const Preintegration before = b.integrate(503 * kMs, 900 * kMs, ImuNoise(), kZero, kZero);
  b.dropBefore(503 * kMs);
  EXPECT_EQ(b.firstTime(), 500 * kMs);
  const Preintegration after = b.integrate(503 * kMs, 900 * kMs, ImuNoise(), kZero, kZero);
  EXPECT_EQ(before.dv(), after.dv());
  EXPECT_EQ(before.dp(), after.dp());
  b.dropBefore(505 * kMs);
  EXPECT_EQ(b.firstTime(), 505 * kMs);
  // After everything: the last reading stays, to refuse what is older.
  b.dropBefore(5000 * kMs);
  EXPECT_EQ(b.firstTime(), 1000 * kMs);
  EXPECT_FALSE(b.add(at(999 * kMs, kZero, kZero)));
}

TEST(ImuBuffer, Statistics) {
  ImuBuffer b;
  // Gyro x alternates 0.1 +- 0.02: mean 0.1, standard deviation 0.02; the accelerometer's y and z
  // by 0.3 and 0.4: 0.5.
  for (int k = 0; k < 100; ++k) {
    const double x = k % 2 ? 1 : -1;
    b.add(at(k * 5 * kMs, Vec3(0.1 + 0.02 * x, 0, 0), Vec3(0, 0.3 * x, 9.81 - 0.4 * x)));
  }
  Vec3 gyro, acc;
  double gyro_std = -1, acc_std = -1;
  ASSERT_TRUE(b.statistics(0, 99 * 5 * kMs, &gyro, &acc, &gyro_std, &acc_std));
  EXPECT_NEAR(gyro.x(), 0.1, 1e-12);
  EXPECT_NEAR(gyro_std, 0.02, 1e-12);
  EXPECT_NEAR(acc.z(), 9.81, 1e-12);
  EXPECT_NEAR(acc_std, 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(b.rate(0, 250 * kMs), 200);
  EXPECT_TRUE(b.statistics(10 * kMs, 20 * kMs, &gyro, &acc, &gyro_std, &acc_std));   // 3 readings
  EXPECT_FALSE(b.statistics(10 * kMs, 19 * kMs, &gyro, &acc, &gyro_std, &acc_std));  // 2
  EXPECT_FALSE(b.statistics(20 * kMs, 10 * kMs, &gyro, &acc, &gyro_std, &acc_std));
  EXPECT_FALSE(ImuBuffer().statistics(0, 1000 * kMs, &gyro, &acc, &gyro_std, &acc_std));
}

}  // namespace
}  // namespace vir::imu
