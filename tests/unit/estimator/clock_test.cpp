/// Cameras have clocks of their own; results are on that of the IMU.
#include <gtest/gtest.h>

#include "estimator_driver.h"

namespace vir::estimator {
namespace {

using vir_test::EstimatorDriver;
using vir_test::kMs;

constexpr TimeNs kStart = 1400000000000000000;

TEST(EstimatorClock, StatesAreOnTheClockOfTheImu) {
  EstimatorConfig config;
  config.camera_time_offset_s = 0.010;
  EstimatorDriver d(1, config);
  d.run(kStart, kStart + 2000 * kMs);
  d.imu(kStart + 2000 * kMs, kStart + 2050 * kMs);
  d.estimator.finish();
  const std::vector<StateEstimate> out = d.estimator.take();
  ASSERT_EQ(out.size(), 40u);
  EXPECT_TRUE(out.back().valid);
  EXPECT_FALSE(out.front().valid);
  for (std::size_t k = 0; k < out.size(); ++k) {
    EXPECT_EQ(out[k].t_image, kStart + static_cast<TimeNs>(k + 1) * 50 * kMs);
    EXPECT_EQ(out[k].state.t, out[k].t_image + 10 * kMs) << k;
  }
  for (const State& s : d.estimator.keyframes()) EXPECT_EQ((s.t - kStart) % (50 * kMs), 10 * kMs);
}

}  // namespace
}  // namespace vir::estimator
