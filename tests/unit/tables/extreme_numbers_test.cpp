/// Numbers as text that are no measurements, in every place of a table: refused, or exact; and what
/// is worked out of them is a number.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "vir/tables/layout.h"
#include "vir/tables/ranges.h"

namespace vir::tables {
namespace {

const std::vector<std::string>& texts() {
  static const std::vector<std::string> all{"0",
                                            "-0",
                                            "4.9e-324",
                                            "1e-300",
                                            "-1e-300",
                                            "1e18",
                                            "-1e18",
                                            "1e308",
                                            "-1e308",
                                            "1e400",
                                            "inf",
                                            "-inf",
                                            "nan",
                                            "2147483648",
                                            "9223372036854775807",
                                            "-9223372036854775808",
                                            "9223372036854775808",
                                            "18446744073709551616",
                                            "1e2147483648",
                                            "1e-9223372036854775809",
                                            std::string(400, '9'),
                                            "0." + std::string(400, '0') + "1",
                                            "",
                                            "-",
                                            "."};
  return all;
}

bool isNoNumber(const std::string& text) {
  TimeNs t = 0;
  return !parseStamp(text, StampUnit::nanoseconds, &t);
}

TEST(ExtremeNumbers, StampsAreExactOrRefused) {
  TimeNs t = 7;
  for (const StampUnit unit : {StampUnit::seconds, StampUnit::milliseconds, StampUnit::microseconds,
                               StampUnit::nanoseconds}) {
    for (const char* text :
         {"1e308", "-1e308", "1e400", "inf", "-inf", "nan", "9223372036854775808",
          "18446744073709551616", "1e2147483648", "", "-", "."}) {
      EXPECT_FALSE(parseStamp(text, unit, &t)) << text << " " << name(unit);
    }
    for (const char* text : {"0", "-0", "4.9e-324", "1e-300", "-1e-300"}) {
      ASSERT_TRUE(parseStamp(text, unit, &t)) << text << " " << name(unit);
      EXPECT_EQ(t, 0) << text;
    }
  }
  ASSERT_TRUE(parseStamp("9223372036854775807", StampUnit::nanoseconds, &t));
  EXPECT_EQ(t, INT64_MAX);
  ASSERT_TRUE(parseStamp("9223372036.854775807", StampUnit::seconds, &t));
  EXPECT_EQ(t, INT64_MAX);
  EXPECT_FALSE(parseStamp("9223372036.854775808", StampUnit::seconds, &t));
  for (const std::string& text : texts()) {
    TimeNs late = INT64_MAX, early = INT64_MIN;
    const bool late_too = addNanoseconds(text, &late);
    EXPECT_EQ(addNanoseconds(text, &early), late_too) << text;
    EXPECT_EQ(late, INT64_MAX) << text;
    EXPECT_EQ(early, INT64_MIN) << text;
  }
}

TEST(ExtremeNumbers, TheUnitOfAnyStamps) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const std::string& a : texts()) {
    for (const std::string& b : texts()) {
      for (const double step_s :
           {0.0, 1e-300, 0.05, 1e308, kInfinite, std::numeric_limits<double>::quiet_NaN()}) {
        const UnitGuess guess = guessUnit({a, b, a, b}, step_s);
        if (isNoNumber(a) && isNoNumber(b)) {
          EXPECT_FALSE(guess.unix_time || guess.sure) << a << " and " << b;
        }
      }
    }
  }
}

/// Columns are within the table, and factors are numbers.
TEST(ExtremeNumbers, TablesOfAnyNumbers) {
  for (const char* header : {"", "#t,wx,wy,wz,ax,ay,az,range,anchor\n",
                             "#timestamp [ns],p_x [m],p_y,p_z,q_w,q_x,q_y,q_z,valid\n"}) {
    for (const std::string& x : texts()) {
      for (std::size_t at = 0; at <= 9; ++at) {
        std::string text = header;
        for (int row = 0; row < 5; ++row) {
          for (std::size_t c = 0; c < 9; ++c) {
            text += (c == at || at == 9 ? x : std::to_string(row + 3)) + (c < 8 ? "," : "\n");
          }
        }
        SCOPED_TRACE(text);
        const Layout layout = layoutOfText(text);
        const int columns = static_cast<int>(layout.columns);
        const ImuColumns imu = imuColumns(layout);
        const PoseColumns pose = poseColumns(layout);
        const RangeColumns range = rangeColumns(layout);
        if (columns == 9) {
          EXPECT_LT(imu.last(), columns);
          EXPECT_LT(pose.last(), columns);
        }
        EXPECT_TRUE(std::isfinite(imu.gyro_unit) && std::isfinite(imu.acc_unit) &&
                    std::isfinite(pose.unit_m) && std::isfinite(range.unit_m));
        EXPECT_TRUE(std::isfinite(medianNorm(layout, imu.acc)));
        EXPECT_LT(stampColumn(layout), std::max(1, columns));
        stampUnit(layout, stampColumn(layout), 0.01);
        whyNoPoses(layout);
        whyNoRanges(layout);
        assumedOrder(layout, pose);
      }
    }
  }
}

}  // namespace
}  // namespace vir::tables
