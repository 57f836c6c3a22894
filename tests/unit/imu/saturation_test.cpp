#include "vir/imu/saturation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vir::imu {
namespace {

constexpr TimeNs kPeriod = 5'000'000;

/// 200 Hz, shaking by 30 m/s^2 and 4 rad/s.
ImuSample reading(int k) {
  const double t = 0.005 * k;
  return {k * kPeriod, Vec3(4 * std::sin(9 * t), 0.3 * std::cos(5 * t), 0.2 * std::cos(t)),
          Vec3(std::sin(20 * t), 2 * std::cos(31 * t), 9.81 + 30 * std::sin(7 * t))};
}

double cut(double v, double range) { return std::clamp(v, -range, range); }

TEST(Saturation, GoodReadingsAreNone) {
  SaturationCounter c;
  for (int k = 0; k < 2000; ++k) c.add(reading(k));
  EXPECT_EQ(c.readings(), 0);
  EXPECT_EQ(c.where(), "");
  EXPECT_EQ(c.longestS(), 0);
}

TEST(Saturation, StretchesAtTheEndOfTheRangeAreCountedAndNamed) {
  SaturationCounter c;
  long cut_off = 0, longest = 0, run = 0;
  for (int k = 0; k < 2000; ++k) {
    ImuSample s = reading(k);
    run = s.acc.z() > 2 * 9.81 ? run + 1 : 0;
    longest = std::max(longest, run);
    cut_off += s.acc.z() > 2 * 9.81 ? 1 : 0;
    cut_off += s.acc.z() < -2 * 9.81 ? 1 : 0;
    s.acc.z() = cut(s.acc.z(), 2 * 9.81);
    c.add(s);
  }
  EXPECT_EQ(c.readings(), cut_off);
  EXPECT_EQ(c.where(), "accelerometer z at 19.62 m/s^2");
  EXPECT_NEAR(c.longestS(), 0.005 * static_cast<double>(longest - 1), 1e-9);
}

TEST(Saturation, TheGyroBelowZero) {
  SaturationCounter c;
  for (int k = 0; k < 2000; ++k) {
    ImuSample s = reading(k);
    s.gyro.x() = std::max(s.gyro.x(), -2.18166);  // 125 deg/s
    c.add(s);
  }
  EXPECT_GT(c.readings(), 500);
  EXPECT_EQ(c.where(), "gyro x at 2.182 rad/s");
}

/// What looked like the end of the range was none.
TEST(Saturation, ALargerReadingTakesItBack) {
  SaturationCounter c;
  for (int k = 0; k < 10; ++k) {
    ImuSample s = reading(k);
    s.acc.x() = 25;
    c.add(s);
  }
  EXPECT_EQ(c.readings(), 10);
  ImuSample s = reading(10);
  s.acc.x() = 26;
  c.add(s);
  EXPECT_EQ(c.readings(), 0);
}

TEST(Saturation, ASensorThatRepeatsItselfIsNone) {
  SaturationCounter c;
  for (int k = 0; k < 100; ++k) {
    ImuSample s = reading(0);
    s.t = k * kPeriod;
    s.acc.x() = 25;
    c.add(s);
  }
  EXPECT_EQ(c.readings(), 0);
}

TEST(Saturation, TwoInARowAreNone) {
  SaturationCounter c;
  for (int k = 0; k < 100; ++k) {
    ImuSample s = reading(k);
    s.acc.x() = k % 3 == 0 ? 0 : 25;
    c.add(s);
  }
  EXPECT_EQ(c.readings(), 0);
}

}  // namespace
}  // namespace vir::imu
