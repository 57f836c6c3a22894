#include "vir/tables/row_format.h"

#include <gtest/gtest.h>

#include "vir/tables/layout.h"

namespace vir::tables {
namespace {

using Texts = std::vector<std::string>;

Texts split(const RowFormat& format, const std::string& line) {
  RowSplitter splitter(format);
  std::vector<std::string_view> fields;
  splitter.split(line, &fields);
  return {fields.begin(), fields.end()};
}

TimeNs timeOf(const std::string& date) {
  const Layout layout = layoutOfText("time,x\n" + date + ",1\n");
  TimeNs t = -1;
  const UnitGuess guess = stampUnit(layout, 0, 0.05);
  EXPECT_TRUE(guess.sure) << date;
  EXPECT_TRUE(guess.unix_time) << date;
  EXPECT_TRUE(parseStamp(layout.rows[0][0], guess.unit, &t)) << date;
  return t;
}

TEST(RowFormat, DatesInAnyNotationAreExactToTheNanosecond) {
  constexpr TimeNs kNoon = 1'714'564'800'000'000'000;  // date -u -d 2024-05-01T12:00:00Z +%s
  EXPECT_EQ(timeOf("2024-05-01T12:00:00.123Z"), kNoon + 123'000'000);
  EXPECT_EQ(timeOf("2024-05-01T12:00:00Z"), kNoon);
  EXPECT_EQ(timeOf("2024-05-01 12:00:00.123456789"), kNoon + 123'456'789);
  EXPECT_EQ(timeOf("2024-05-01T14:00:00.5+02:00"), kNoon + 500'000'000);
  EXPECT_EQ(timeOf("2024-05-01T14:00:00+0200"), kNoon);
  EXPECT_EQ(timeOf("2024-05-01T07:00:00-05"), kNoon);
  EXPECT_EQ(timeOf("2024-05-01 12:00:00 UTC"), kNoon);
  EXPECT_EQ(timeOf("20240501T120000.25"), kNoon + 250'000'000);
  EXPECT_EQ(timeOf("2024/05/01 12:00:00"), kNoon);
  EXPECT_EQ(timeOf("1.5.2024 12:00:00"), kNoon);
  EXPECT_EQ(timeOf("\"2024-05-01 12:00:00\""), kNoon);
  EXPECT_EQ(timeOf("2024-02-29T00:00:00Z"), 1'709'164'800'000'000'000);
}

TEST(RowFormat, WhatIsNoDateStaysAsItIs) {
  for (const char* text :
       {"2024-13-01T12:00:00", "2023-02-29T12:00:00", "2024-05-01T24:00:01", "2024-05-01",
        "5/1/2024 12:00:00", "2024-05-01T12:00:00.Z", "12:60:00"}) {
    const Layout layout = layoutOfText(std::string("time,x\n") + text + ",1\n");
    EXPECT_EQ(layout.kind(0), ColumnKind::other) << text;
    EXPECT_EQ(layout.rows[0][0], text);
  }
}

TEST(RowFormat, ABrokenDateAmongManyIsLeftForTheReport) {
  std::string text = "time,x\n";
  for (int i = 10; i < 40; ++i) text += "2024-05-01T12:00:" + std::to_string(i) + ",1\n";
  const Layout layout = layoutOfText(text + "rubbish,1\n");
  EXPECT_EQ(layout.kind(0), ColumnKind::date);
  EXPECT_EQ(layout.rows[0][0], "1714564810");
  EXPECT_EQ(layout.rows[30][0], "rubbish");
}

TEST(RowFormat, TimesOfDayGoOnBehindMidnight) {
  const Layout layout =
      layoutOfText("t,x\n23:59:59.995,1\n00:00:00.000,2\n23:59:59.998,3\n00:00:00.005,4\n");
  EXPECT_EQ(layout.kind(0), ColumnKind::clock);
  EXPECT_EQ(layout.column(0), (Texts{"86399.995", "86400.000", "86399.998", "86400.005"}));
  EXPECT_EQ(stampUnit(layout, 0, 0.005).unit, StampUnit::seconds);
  EXPECT_TRUE(stampUnit(layout, 0, 0.005).sure);
  EXPECT_FALSE(stampRemark(layout, 0).empty());
}

TEST(RowFormat, DateAndTimeOfDayInTwoColumnsAreOne) {
  const Layout named = layoutOfText("date,time,x\n2024-05-01,12:00:00.5,7\n");
  EXPECT_EQ(named.columns, 2u);
  EXPECT_EQ(named.names, (Texts{"time", "x"}));
  EXPECT_EQ(named.rows[0], (Texts{"1714564800.5", "7"}));
  const Layout blanks = layoutOfText("# time x y\n2024-05-01 12:00:00.5 7 8\n");
  EXPECT_EQ(blanks.names, (Texts{"time", "x", "y"}));
  EXPECT_EQ(blanks.rows[0], (Texts{"1714564800.5", "7", "8"}));
  EXPECT_EQ(stampColumn(layoutOfText("7,2024-05-01T12:00:00\n8,2024-05-01T12:00:01\n")), 1);
}

TEST(RowFormat, DecimalCommas) {
  const Layout german = layoutOfText("t;x;name\n1,5;-2,5e-3;a,b\n2,5;3;1,2,3\n");
  EXPECT_TRUE(german.decimal_comma);
  EXPECT_EQ(german.rows[0], (Texts{"1.5", "-2.5e-3", "a,b"}));
  EXPECT_EQ(german.rows[1], (Texts{"2.5", "3", "1,2,3"}));
  EXPECT_EQ(layoutOfText("1,5\t2,5\n").rows[0], (Texts{"1.5", "2.5"}));
  EXPECT_EQ(layoutOfText("1,5 2,5 3\n").rows[0], (Texts{"1.5", "2.5", "3"}));
  EXPECT_EQ(layoutOfText("01.05.2024 12:00:00,123;2,5\n").rows[0],
            (Texts{"1714564800.123", "2.5"}));
  // Points are points.
  EXPECT_FALSE(layoutOfText("1.5;2.5\n").decimal_comma);
  EXPECT_EQ(layoutOfText("1,5,2\n").rows[0].size(), 3u);
  EXPECT_EQ(layoutOfText("1, 2, 3\n").rows[0].size(), 3u);
  EXPECT_EQ(split({}, "1  2\t3"), (Texts{"1", "2", "3"}));
}

TEST(RowFormat, CommasAreDecimalBesideStampsWithPoints) {
  for (const std::string stamp : {"1400000003.064509630", "2014-05-13 16:53:23.064509630"}) {
    const std::string line = stamp + ";0xDECA010203040506;2086,781";
    const RowFormat format = rowFormatOf({line, line}, ';');
    EXPECT_TRUE(format.decimal_comma) << stamp;
    RowSplitter splitter(format);
    std::vector<std::string_view> fields;
    splitter.split(line, &fields);
    ASSERT_EQ(fields.size(), 3u);
    EXPECT_EQ(fields[0], "1400000003.064509630") << stamp;
    EXPECT_EQ(fields[2], "2086.781") << stamp;
  }
}

}  // namespace
}  // namespace vir::tables
