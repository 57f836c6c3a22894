#include "vir/core/host_clock.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace vir {
namespace {

TimeNs g_wall = 0, g_monotonic = 0, g_awake = 0;

TEST(HostClock, OncePinnedNobodySetsIt) {
  useHostClocks({[] { return g_wall; }, [] { return g_monotonic; }, [] { return g_awake; }});
  g_wall = 1'000'000;
  EXPECT_EQ(hostNow(), 1'000'000);
  g_wall = 2'000'000;
  EXPECT_EQ(hostNow(), 2'000'000) << "before, it is the wall clock";
  EXPECT_EQ(hostClockStep(), 0);
  g_monotonic = 500;
  pinHostClock();
  g_monotonic += 300;
  g_wall += 300;
  EXPECT_EQ(hostNow(), 2'000'300);
  EXPECT_EQ(hostClockStep(), 0);
  g_wall -= 1'500'000;
  EXPECT_EQ(hostNow(), 2'000'300);
  EXPECT_EQ(hostClockStep(), -1'500'000);
  g_awake = 300;
  const TimeNs before = hostSlept();
  g_monotonic += 2'000'000'400;
  g_awake += 400;
  EXPECT_EQ(hostSlept() - before, 2'000'000'000) << "a sleep of two seconds";
  unsetenv("VIR_SLAM_CLOCK_OFFSET_NS");
  useHostClocks(systemClocks());
  EXPECT_GT(hostNow(), 1'600'000'000'000'000'000);
}

}  // namespace
}  // namespace vir
