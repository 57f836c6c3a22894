/// What looks at a live stream takes no more memory the longer it lasts, and sees the same.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "found.h"
#include "vir/check/imu_check.h"
#include "vir/check/stream_check.h"
#include "vir/core/random.h"
#include "vir_test_heap.h"

namespace vir::check {
namespace {

constexpr TimeNs kStart = 1'400'000'000'000'000'000;

/// 100 readings a second of something that is carried about; `unit`: of the accelerometer.
void carry(int from_s, int to_s, double unit, ImuCheck* imu, StreamCheck* stream) {
  Random random(static_cast<std::uint64_t>(from_s));
  const auto noise = [&random] { return Vec3(random.normal(), random.normal(), random.normal()); };
  for (int i = 100 * from_s; i < 100 * to_s; ++i) {
    const double t = 0.01 * i;
    const Vec3 tilt(0.3 * std::sin(0.9 * t), 0.3 + 0.2 * std::cos(0.7 * t), 0);
    ImuSample s;
    s.t = kStart + i * 10'000'000LL;
    s.acc = unit * (expSO3(tilt).transpose() * Vec3(0, 0, 9.81) + 0.02 * noise());
    s.gyro = Vec3(0.27 * std::cos(0.9 * t), -0.14 * std::sin(0.7 * t), 0.8 * std::sin(0.5 * t)) +
             0.002 * noise();
    imu->add(s);
    stream->add(s.t);
  }
}

TEST(LongStream, MemoryStaysAsItIs) {
  if (!test::heapIsCounted()) GTEST_SKIP() << "the heap is the sanitizer's";
  const test::HeapPeak heap;
  ImuCheck imu("IMU0", ImuCheck::Keeps::evenly);
  StreamCheck stream("IMU0", StreamKind::imu);
  carry(0, 3000, 1, &imu, &stream);
  const long after_a_while = heap.now();
  carry(3000, 12000, 1, &imu, &stream);
  EXPECT_LT(heap.now() - after_a_while, 10'000) << "bytes in 2.5 hours";
}

TEST(LongStream, IsJudgedAsAShortOne) {
  for (const double unit : {1.0, 1 / 9.81}) {
    ImuCheck whole("IMU0"), thinned("IMU0", ImuCheck::Keeps::evenly);
    StreamCheck stream("IMU0", StreamKind::imu);
    carry(0, 5000, unit, &whole, &stream);
    carry(0, 5000, unit, &thinned, &stream);
    const auto expected = seriousKinds(whole.findings(std::nullopt, std::nullopt));
    EXPECT_EQ(expected.size(), unit == 1 ? 0u : 1u);
    EXPECT_EQ(seriousKinds(thinned.findings(std::nullopt, std::nullopt)), expected);
    EXPECT_NEAR(thinned.restMagnitude(), whole.restMagnitude(), 1e-3 * whole.restMagnitude());
  }
}

}  // namespace
}  // namespace vir::check
