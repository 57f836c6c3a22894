#include "vir/tables/stamps.h"

#include <gtest/gtest.h>

#include <limits>

namespace vir::tables {
namespace {

TimeNs parsed(const std::string& text, StampUnit unit) {
  TimeNs t = -1;
  EXPECT_TRUE(parseStamp(text, unit, &t)) << text;
  return t;
}

TEST(Stamps, AreExactInEveryUnitAndNotation) {
  const TimeNs t = 1403636580838555648;
  EXPECT_EQ(parsed("1403636580838555648", StampUnit::nanoseconds), t);
  EXPECT_EQ(parsed("1403636580838555.648", StampUnit::microseconds), t);
  EXPECT_EQ(parsed("1403636580838.555648", StampUnit::milliseconds), t);
  EXPECT_EQ(parsed("1403636580.838555648", StampUnit::seconds), t);
  EXPECT_EQ(parsed("1.403636580838555648e+09", StampUnit::seconds), t);
  EXPECT_EQ(parsed("1.403636580838555648000e18", StampUnit::nanoseconds), t);
  EXPECT_EQ(parsed("1400000000000", StampUnit::milliseconds), 1400000000000000000);
  EXPECT_EQ(parsed("0.0000000014", StampUnit::seconds), 1);
  EXPECT_EQ(parsed("0.0000000015", StampUnit::seconds), 2);
  EXPECT_EQ(parsed("-1.5", StampUnit::seconds), -1500000000);
  EXPECT_EQ(parsed("0", StampUnit::seconds), 0);
}

TEST(Stamps, RefuseWhatIsNone) {
  TimeNs t = 0;
  for (const char* bad : {"", "-", ".", "abc", "1a", "1.2.3", "1e", "1e+", "1e999", "nan", "inf",
                          "99999999999999999999", "9223372036854775808"}) {
    EXPECT_FALSE(parseStamp(bad, StampUnit::nanoseconds, &t)) << bad;
  }
  EXPECT_FALSE(parseStamp("1e12", StampUnit::seconds, &t));
}

/// 20 stamps from `first` on, `step` apart.
std::vector<std::string> column(long first, long step) {
  std::vector<std::string> out;
  for (int i = 0; i < 20; ++i) out.push_back(std::to_string(first + i * step));
  return out;
}

TEST(StampUnit, IsKnownByTheDate) {
  EXPECT_EQ(guessUnit(column(1400000000000000000, 5000000), 0.005).unit, StampUnit::nanoseconds);
  EXPECT_EQ(guessUnit(column(1400000000000000, 5000), 0.005).unit, StampUnit::microseconds);
  EXPECT_EQ(guessUnit(column(1400000000000, 5), 0.005).unit, StampUnit::milliseconds);
  EXPECT_EQ(guessUnit({"1400000000.000000", "1400000000.005000"}, 0.005).unit, StampUnit::seconds);
  EXPECT_EQ(guessUnit({"1400000000000.25", "1400000000005.25"}, 0.005).unit,
            StampUnit::milliseconds);
  EXPECT_EQ(guessUnit({"1400000000000000.5", "1400000000005000.5"}, 0.005).unit,
            StampUnit::microseconds);
  EXPECT_EQ(guessUnit({"1.4e9", "1.400000001e9"}, 0.005).unit, StampUnit::seconds);
  EXPECT_TRUE(guessUnit(column(1400000000000, 50), 0.05).unix_time);
}

TEST(StampUnit, AHeaderThatWasCopiedDoesNotOverruleTheDate) {
  const UnitGuess guess = guessUnit(column(1400000000000, 5), 0.005, StampUnit::nanoseconds);
  EXPECT_EQ(guess.unit, StampUnit::milliseconds);
}

TEST(StampUnit, OfAClockSincePowerUpIsKnownByTheStep) {
  EXPECT_EQ(guessUnit(column(43847434001234, 5000000), 0.005).unit, StampUnit::nanoseconds);
  // In milliseconds it would be a date, with readings 83 minutes apart.
  EXPECT_EQ(guessUnit(column(1400000000000, 5000000), 0.005).unit, StampUnit::nanoseconds);
  EXPECT_EQ(guessUnit(column(20000, 5000), 0.005).unit, StampUnit::microseconds);
  EXPECT_EQ(guessUnit(column(0, 5), 0.005).unit, StampUnit::milliseconds);
  EXPECT_EQ(guessUnit({"0.000", "0.050", "0.100"}, 0.05).unit, StampUnit::seconds);
  EXPECT_FALSE(guessUnit(column(0, 5), 0.005).unix_time);
  EXPECT_FALSE(guessUnit({"7"}, 0.05).sure);
}

TEST(Stamps, NanosecondsOfASecondAreAdded) {
  TimeNs t = 5'000'000'000;
  EXPECT_TRUE(addNanoseconds("999999999", &t));
  EXPECT_EQ(t, 5'999'999'999);
  for (const char* bad : {"1000000000", "-1", "x", ""}) {
    EXPECT_FALSE(addNanoseconds(bad, &t)) << bad;
  }
  EXPECT_EQ(t, 5'999'999'999);
  TimeNs last = std::numeric_limits<TimeNs>::max() - 1;
  EXPECT_FALSE(addNanoseconds("2", &last));
  EXPECT_TRUE(addNanoseconds("1", &last));
}

}  // namespace
}  // namespace vir::tables
