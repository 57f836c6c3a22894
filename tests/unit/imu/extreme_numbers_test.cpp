/// Numbers that are no measurements: an exception, or an answer of numbers.
#include <gtest/gtest.h>

#include <stdexcept>

#include "vir/imu/imu_buffer.h"
#include "vir/imu/saturation.h"
#include "vir/imu/spike_filter.h"
#include "vir_test_extremes.h"

namespace vir::imu {
namespace {

constexpr TimeNs kPeriod = 5'000'000;

/// What gets through to be integrated is numbers, and so is what it is integrated to.
TEST(ExtremeNumbers, OneReadingOnItsWayToTheIntegral) {
  test::forExtremeVectors(Vec3(0.1, 0, 9.81), [](const Vec3& v) {
    for (const bool gyro : {false, true}) {
      SpikeFilter filter;
      SaturationCounter saturation;
      ImuBuffer buffer;
      for (int k = 0; k < 300; ++k) {
        ImuSample s{k * kPeriod, Vec3(0.1, 0.02 * (k % 3), 0), Vec3(0, 0.1 * (k % 5), 9.81)};
        if (k == 150) (gyro ? s.gyro : s.acc) = v;
        saturation.add(s);
        for (const ImuSample& a : filter.add(s)) buffer.add(a);
      }
      const Preintegration p =
          buffer.integrate(100 * kPeriod, 250 * kPeriod, ImuNoise(), Vec3::Zero(), Vec3::Zero());
      EXPECT_TRUE(p.dp().allFinite() && p.dv().allFinite() && p.dq().coeffs().allFinite());
      EXPECT_TRUE(p.covariance().allFinite());
      EXPECT_TRUE(p.sqrtInformation().allFinite());
      EXPECT_LT(p.dv().norm(), 20) << v.transpose();
    }
  });
}

TEST(ExtremeNumbers, StampsAnywhere) {
  ImuBuffer buffer;
  SpikeFilter filter;
  for (const TimeNs t : {INT64_MIN, TimeNs(-1), TimeNs(0), TimeNs(1), INT64_MAX}) {
    for (const ImuSample& s : filter.add({t, Vec3::Zero(), Vec3(0, 0, 9.81)})) buffer.add(s);
  }
  EXPECT_EQ(buffer.lastTime(), INT64_MAX);
}

}  // namespace
}  // namespace vir::imu
