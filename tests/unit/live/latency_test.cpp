#include "vir/live/latency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace vir::live {
namespace {

TEST(LatencyCounter, NothingYet) {
  const Latency none = LatencyCounter().summary();
  EXPECT_EQ(none.count, 0);
  EXPECT_EQ(none.median_ms, 0);
  EXPECT_EQ(none.max_ms, 0);
}

TEST(LatencyCounter, QuantilesToOnePercentAndTheLongestExactly) {
  LatencyCounter counter;
  for (int i = 1; i <= 10000; ++i) counter.add(0.01 * i);
  const Latency l = counter.summary();
  EXPECT_EQ(l.count, 10000);
  EXPECT_NEAR(l.median_ms, 50, 0.5);
  EXPECT_NEAR(l.p95_ms, 95, 0.95);
  EXPECT_NEAR(l.p99_ms, 99, 0.99);
  EXPECT_EQ(l.max_ms, 100);
}

/// Nothing is longer than the longest, and what no clock says does no harm.
TEST(LatencyCounter, OddOnes) {
  LatencyCounter counter;
  for (int i = 0; i < 100; ++i) counter.add(30);
  EXPECT_LE(counter.summary().p99_ms, 30);
  EXPECT_NEAR(counter.summary().median_ms, 30, 0.3);
  for (const double ms : {-5.0, 0.0, std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    counter.add(ms);
  }
  const Latency l = counter.summary();
  EXPECT_EQ(l.count, 104);
  EXPECT_NEAR(l.median_ms, 30, 0.3);
  EXPECT_EQ(l.max_ms, 1e300);
}

}  // namespace
}  // namespace vir::live
