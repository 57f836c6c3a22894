#include "vir/rawlog/mrpt_time.h"

#include <gtest/gtest.h>

namespace vir::rawlog {
namespace {

TEST(MrptTime, RoundTripIsExactToTheTick) {
  for (const TimeNs t : {TimeNs{0}, TimeNs{1403636584763555500}, TimeNs{-1403636584763555500},
                         TimeNs{100}, TimeNs{-100}, TimeNs{9223372036854775800}}) {
    EXPECT_EQ(fromMrptTime(toMrptTime(t)), t);
  }
}

TEST(MrptTime, BelowATickIsCutTowardsThePast) {
  EXPECT_EQ(fromMrptTime(toMrptTime(1403636584763555584)), 1403636584763555500);
  EXPECT_EQ(fromMrptTime(toMrptTime(199)), 100);
  EXPECT_EQ(fromMrptTime(toMrptTime(-1)), -100);
}

TEST(MrptTime, AgreesWithMrptsOwnClock) {
  EXPECT_NEAR(mrpt::Clock::toDouble(toMrptTime(1403636584763555500)), 1403636584.7635555, 1e-6);
}

TEST(MrptTime, StampsBeyondNanosecondsSaturate) {
  const auto at = [](std::int64_t ticks) {
    return fromMrptTime(mrpt::Clock::time_point(mrpt::Clock::duration(ticks)));
  };
  EXPECT_EQ(at(INT64_MAX), 9223372036854775800);
  EXPECT_EQ(at(INT64_MIN), -9223372036854775800);
  EXPECT_EQ(at(0), -9223372036854775800);
}

}  // namespace
}  // namespace vir::rawlog
