#include "vir/core/parse_number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace vir {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

double numberOf(const std::string& text) {
  double v = -77;
  EXPECT_TRUE(parseNumber(text, &v)) << text;
  return v;
}

TEST(ParseNumber, DecimalNumbers) {
  EXPECT_EQ(numberOf("0"), 0);
  EXPECT_EQ(numberOf("-1.5"), -1.5);
  EXPECT_EQ(numberOf("+1.5e-3"), 1.5e-3);
  EXPECT_EQ(numberOf("2E+2"), 200);
  EXPECT_EQ(numberOf(".5"), 0.5);
  EXPECT_EQ(numberOf("5."), 5);
  EXPECT_EQ(numberOf("0.1000000000000000055511151231257827"), 0.1);
}

TEST(ParseNumber, NotANumberAndTheValueStays) {
  for (const char* bad :
       {"",    "+",   "-",   ".",    "abc", " 1",  "1 ", "1\n",   "1.5x", "1,5",   "--1",
        "+-1", "-+1", "++1", "0x10", "1e",  "1e+", "e5", "1.2.3", "1f",   "1_000", "1d3"}) {
    double v = 7;
    EXPECT_FALSE(parseNumber(bad, &v)) << "'" << bad << "'";
    EXPECT_FALSE(parseFinite(bad, &v)) << "'" << bad << "'";
    EXPECT_EQ(v, 7) << "'" << bad << "'";
  }
  double v = 7;
  EXPECT_FALSE(parseNumber(std::string_view("1\0", 2), &v));
  EXPECT_FALSE(parseNumber(std::string_view(), &v));
}

TEST(ParseNumber, InfiniteAndNan) {
  EXPECT_EQ(numberOf("inf"), kInf);
  EXPECT_EQ(numberOf("-Infinity"), -kInf);
  EXPECT_TRUE(std::isnan(numberOf("nan")));
  for (const char* none : {"inf", "-inf", "nan", "1e400", "-1e400"}) {
    double v = 7;
    EXPECT_FALSE(parseFinite(none, &v)) << none;
    EXPECT_EQ(v, 7) << none;
  }
}

TEST(ParseNumber, BeyondWhatADoubleHolds) {
  EXPECT_EQ(numberOf("1e400"), kInf);
  EXPECT_EQ(numberOf("-1E400"), -kInf);
  EXPECT_EQ(numberOf("1e99999999999999999999999"), kInf);
  EXPECT_EQ(numberOf("1" + std::string(400, '0')), kInf);
  EXPECT_EQ(numberOf("1" + std::string(500, '0') + "e-10"), kInf);
  EXPECT_EQ(numberOf("1e-400"), 0);
  EXPECT_EQ(numberOf("-1e-400"), 0);
  EXPECT_EQ(numberOf("1e-99999999999999999999999"), 0);
  EXPECT_EQ(numberOf("0." + std::string(400, '0') + "1"), 0);
  EXPECT_EQ(numberOf("0." + std::string(500, '0') + "1e+10"), 0);
  double v = 7;
  EXPECT_TRUE(parseFinite("1e-400", &v));
  EXPECT_EQ(v, 0);
}

template <typename T>
bool parses(const std::string& text, T wanted, int base = 10) {
  T v = 77;
  return parseNumber(text, &v, base) && v == wanted;
}

template <typename T>
void expectNone(const std::string& text, int base = 10) {
  T v = 77;
  EXPECT_FALSE(parseNumber(text, &v, base)) << "'" << text << "'";
  EXPECT_EQ(v, 77) << "'" << text << "'";
}

TEST(ParseNumber, WholeNumbers) {
  EXPECT_TRUE(parses<int>("0", 0));
  EXPECT_TRUE(parses<int>("-12", -12));
  EXPECT_TRUE(parses<int>("007", 7));
  EXPECT_TRUE(parses<int>("ff", 255, 16));
  EXPECT_TRUE(parses<int>("FF", 255, 16));
  EXPECT_TRUE(
      parses<std::int64_t>("-9223372036854775808", std::numeric_limits<std::int64_t>::min()));
  EXPECT_TRUE(
      parses<std::uint64_t>("18446744073709551615", std::numeric_limits<std::uint64_t>::max()));
  EXPECT_TRUE(parses<std::uint8_t>("255", 255));
  for (const char* bad :
       {"", "-", "+1", " 1", "1 ", "1.0", "1e3", "0x10", "1,", "a", "--1", "nan"}) {
    expectNone<int>(bad);
  }
  expectNone<int>("fg", 16);
}

TEST(ParseNumber, WholeNumbersThatDoNotFit) {
  expectNone<int>("2147483648");
  expectNone<std::int64_t>("9223372036854775808");
  expectNone<std::uint8_t>("256");
  expectNone<unsigned>("-1");
  expectNone<long>("99999999999999999999999999");
}

TEST(ParseBool, TakesThreeWordsForEach) {
  for (const char* yes : {"true", "Yes", "1"}) {
    bool value = false;
    EXPECT_TRUE(parseBool(yes, &value)) << yes;
    EXPECT_TRUE(value) << yes;
  }
  for (const char* no : {"FALSE", "no", "0"}) {
    bool value = true;
    EXPECT_TRUE(parseBool(no, &value)) << no;
    EXPECT_FALSE(value) << no;
  }
  bool value = true;
  for (const char* bad : {"", "2", "y", " true", "on", "01"}) {
    EXPECT_FALSE(parseBool(bad, &value)) << bad;
  }
  EXPECT_TRUE(value);
}

}  // namespace
}  // namespace vir
