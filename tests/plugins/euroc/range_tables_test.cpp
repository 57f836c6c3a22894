/// What tables of ranges say beside the ranges, and other ways to write them.
#include <gtest/gtest.h>

#include <optional>
#include <sstream>

#include "input_error.h"
#include "recording.h"
#include "table_folder.h"
#include "vir_test_temp_folder.h"

namespace vir::euroc {
namespace {

struct Content {
  std::vector<RangeRow> ranges;
  std::vector<std::string> labels;
  std::string notes;
  std::vector<SurveyedAnchor> standing;
  ProblemLog log;
};

/// Of `uwb.csv`: a header and rows, beside an IMU.
Content read(const std::string& table, const std::vector<double>& lever_arm_m = {1, 2, 3}) {
  const test::TempFolder temp;
  test::writeText(temp.path() / "uwb.csv", table);
  std::string imu = "timestamp,gx,gy,gz,ax,ay,az\n";
  for (int i = 0; i < 40; ++i) {
    imu += std::to_string(1400000003000000000 + i * 5'000'000L) + ",0,0,0,0,0,9.81\n";
  }
  test::writeText(temp.path() / "imu.csv", imu);
  EurocOptions o;
  o.section = "csv";
  o.source = temp.path().string();
  o.lever_arm_m = lever_arm_m;
  o.range_sigma_m = 0.07;
  Content c;
  Recording recording(findTables(o), o, &c.log);
  Event e;
  while (recording.next(&e)) {
    const auto* range = std::get_if<RangeRow>(&e.what);
    if (range == nullptr) continue;
    c.ranges.push_back(*range);
    c.labels.push_back(recording.rangeStreams()[e.stream].label);
  }
  c.standing = recording.anchorPlaces().standing();
  for (const std::string& m : c.log.messages()) c.notes += m + "\n";
  return c;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Rows 50 ms apart, each `line` of its number.
template <typename Line>
std::string rows(const std::string& header, int n, Line line) {
  std::string out = header + "\n";
  for (int i = 0; i < n; ++i) {
    out += std::to_string(1400000003000000000 + i * 50'000'000L) + "," + line(i) + "\n";
  }
  return out;
}

TEST(RangeTables, ComeBackAsTheyAreExported) {
  const Content c = read(
      "t_ns,beacon_id,range_m,std_m,antenna_x_m,antenna_y_m,antenna_z_m\n"
      "1400000003064509600,1000000,2.0069883,0.1,0.1,0.3,0.05\n"
      "1400000003115916000,1000000,2.134011,0.2,0.1,0.3,0.05\n");
  ASSERT_EQ(c.ranges.size(), 2u) << c.notes;
  EXPECT_EQ(c.ranges[0].t, 1400000003064509600);
  EXPECT_EQ(c.ranges[0].anchor, 1000000);
  EXPECT_EQ(c.ranges[0].range_m, 2.0069883);
  EXPECT_EQ(c.ranges[0].sigma_m, 0.1);
  EXPECT_EQ(c.ranges[1].sigma_m, 0.2);
  ASSERT_TRUE(c.ranges[1].place.has_value());
  EXPECT_EQ(*c.ranges[1].place, Vec3(0.1, 0.3, 0.05));
  EXPECT_FALSE(contains(c.notes, "of the settings")) << c.notes;
  EXPECT_TRUE(contains(c.notes, "no images: ")) << c.notes;
}

TEST(RangeTables, EachAntennaHasThePlaceOfItsColumns) {
  for (const std::string header :
       {"timestamp,antenna_id,antenna_x,antenna_y,antenna_z,anchor,range_m",
        "timestamp,tag,lever_x [m],lever_y [m],lever_z [m],anchor,range_m",
        "timestamp,tag_id,tag_x,tag_y,tag_z,anchor_id,range"}) {
    const auto line = [](int i) {
      return i % 2 == 0 ? std::string("a,0,0.3,0.05,7,2.5") : std::string("b,0,-0.3,0.05,7,2.7");
    };
    const Content c = read(rows(header, 6, line));
    ASSERT_EQ(c.ranges.size(), 6u) << header << c.notes;
    EXPECT_EQ(*c.ranges[0].place, Vec3(0, 0.3, 0.05)) << header;
    EXPECT_EQ(*c.ranges[1].place, Vec3(0, -0.3, 0.05)) << header;
    EXPECT_EQ(c.labels[0], "UWB0");
    EXPECT_EQ(c.labels[1], "UWB1");
    EXPECT_EQ(c.ranges[0].sigma_m, 0.07);
    EXPECT_TRUE(contains(c.notes, "tells no noise; range_sigma_m of the settings")) << c.notes;
    EXPECT_FALSE(contains(c.notes, "only one position is known")) << c.notes;
    // Several in the settings go before.
    const Content set = read(rows(header, 6, line), {1, 0, 0, 2, 0, 0});
    EXPECT_EQ(*set.ranges[1].place, Vec3(2, 0, 0)) << header;
  }
}

TEST(RangeTables, WhereTheTagIsInTheWorldIsNoPlaceOnTheRobot) {
  const Content c = read(rows("timestamp,anchor,range,tag_x,tag_y,tag_z", 12,
                              [](int i) { return "7,2.5," + std::to_string(0.1 * i) + ",1,1"; }));
  ASSERT_EQ(c.ranges.size(), 12u);
  EXPECT_EQ(*c.ranges[0].place, Vec3(1, 2, 3));
  EXPECT_TRUE(contains(c.notes, "tag_x, tag_y, tag_z are not used")) << c.notes;
}

TEST(RangeTables, NoiseInAnyUnit) {
  const auto sigma = [](const std::string& column, const std::string& value) {
    const Content c =
        read(rows("timestamp,anchor,range," + column, 3, [&](int) { return "7,2.5," + value; }));
    return c.ranges.size() == 3u ? c.ranges[2].sigma_m : -1.0;
  };
  EXPECT_DOUBLE_EQ(sigma("std [mm]", "50"), 0.05);
  EXPECT_DOUBLE_EQ(sigma("sigma", "0.04"), 0.04);
  EXPECT_DOUBLE_EQ(sigma("noise", "0.03"), 0.03);
  EXPECT_DOUBLE_EQ(sigma("std_m", "0.02"), 0.02);
  EXPECT_DOUBLE_EQ(sigma("noise", "48"), 0.07);  // what a radio counts
  EXPECT_DOUBLE_EQ(sigma("std", "0"), 0.07);
}

TEST(RangeTables, RowsThatAreNotValidAreLeftOut) {
  const Content c = read(rows("timestamp,anchor,range,valid,rssi", 6, [](int i) {
    return i % 3 == 0 ? std::string("7,99.0,0,-80") : std::string("7,2.5,1,-80");
  }));
  EXPECT_EQ(c.ranges.size(), 4u);
  EXPECT_EQ(c.log.get("range_not_valid"), 2);
  for (const RangeRow& r : c.ranges) EXPECT_EQ(r.range_m, 2.5);
  EXPECT_TRUE(contains(c.notes, "columns that are not used: rssi")) << c.notes;
}

TEST(RangeTables, BlockedOnesAreKeptAndCounted) {
  const Content blocked = read(rows("timestamp,anchor,range,nlos", 5, [](int i) {
    return "7,2.5," + std::string(i == 1 ? "1" : "0");
  }));
  EXPECT_EQ(blocked.ranges.size(), 5u);
  EXPECT_EQ(blocked.log.get("range_without_line_of_sight"), 1);
  EXPECT_TRUE(contains(blocked.notes, "blocked (no line of sight) are kept")) << blocked.notes;
  const Content free = read(rows("timestamp,anchor,range,los", 5, [](int i) {
    return "7,2.5," + std::string(i == 1 ? "true" : "false");
  }));
  EXPECT_EQ(free.log.get("range_without_line_of_sight"), 4);
}

TEST(RangeTables, AColumnForEachAnchor) {
  const Content c = read(rows("timestamp,A1,d_0x84 [cm],A3", 6, [](int i) {
    return std::string(i == 2 ? "" : "2.5") + ",310," + (i == 3 ? "nan" : "4");
  }));
  EXPECT_EQ(c.ranges.size(), 16u) << c.notes;
  EXPECT_EQ(c.log.get("range_not_measured"), 2);
  EXPECT_EQ(c.ranges[1].anchor, 0x84);
  EXPECT_DOUBLE_EQ(c.ranges[1].range_m, 3.1);
  EXPECT_TRUE(contains(c.notes, "to A1, 0x84, A3")) << c.notes;
}

TEST(RangeTables, TheAnchorIsWhereTheNamesVary) {
  const Content to = read(rows("timestamp,src,dst,range", 6,
                               [](int i) { return "9," + std::to_string(i % 3) + ",2.5"; }));
  ASSERT_EQ(to.ranges.size(), 6u) << to.notes;
  EXPECT_EQ(to.ranges[2].anchor, 2);
  const Content from = read(
      rows("timestamp,src,dst,range", 6, [](int i) { return std::to_string(i % 3) + ",9,2.5"; }));
  ASSERT_EQ(from.ranges.size(), 6u) << from.notes;
  EXPECT_EQ(from.ranges[2].anchor, 2);
}

TEST(RangeTables, TimesOfFlightNeedTheirUnit) {
  const auto line = [](int) { return std::string("7,10"); };
  const Content ns = read(rows("timestamp,anchor,tof [ns]", 4, line));
  ASSERT_EQ(ns.ranges.size(), 4u) << ns.notes;
  EXPECT_NEAR(ns.ranges[0].range_m, 2.997, 1e-3);
  const Content none = read(rows("timestamp,anchor,tof", 4, line));
  EXPECT_EQ(none.ranges.size(), 0u);
  EXPECT_EQ(none.log.get("range_no_range"), 4);
  EXPECT_TRUE(contains(none.notes, "time of flight without a unit")) << none.notes;
}

TEST(RangeTables, AnchorsThatAlwaysStandAtOnePlaceAreSurveyed) {
  for (const std::string header : {"t,anchor_id,range_m,anchor_x,anchor_y,anchor_z",
                                   "t,anchor,range,anchor_x [m],anchor_y [m],anchor_z [m]",
                                   "t,id,distance,beacon_pos_x,beacon_pos_y,beacon_pos_z"}) {
    const Content c = read(rows(header, 8, [](int i) {
      return i % 2 == 0 ? std::string("4,3.5,1.5,-2,0.25") : std::string("0x84,4.5,7,8,2.5");
    }));
    ASSERT_EQ(c.ranges.size(), 8u) << header << c.notes;
    ASSERT_EQ(c.standing.size(), 2u) << header << c.notes;
    EXPECT_EQ(c.standing[0].id, 4u);
    EXPECT_EQ(c.standing[0].p_S, Vec3(1.5, -2, 0.25));
    EXPECT_EQ(c.standing[1].id, 0x84u);
    EXPECT_EQ(c.standing[1].p_S, Vec3(7, 8, 2.5));
    EXPECT_FALSE(contains(c.notes, "not used")) << c.notes;
  }
}

TEST(RangeTables, AnchorsThatMoveAreLeftOutOfTheSurvey) {
  const Content c =
      read(rows("t,anchor_id,range_m,anchor_x_mm,anchor_y_mm,anchor_z_mm", 8, [](int i) {
        const std::string moved = "," + std::to_string(1000 + 100 * i) + ",0,500";
        return i % 2 == 0 ? "4,3.5" + moved : std::string("5,4.5,7000,8000,2500");
      }));
  ASSERT_EQ(c.ranges.size(), 8u) << c.notes;
  ASSERT_EQ(c.standing.size(), 1u) << c.notes;
  EXPECT_EQ(c.standing[0].id, 5u);
  EXPECT_NEAR((c.standing[0].p_S - Vec3(7, 8, 2.5)).norm(), 0, 1e-12);
  EXPECT_TRUE(contains(c.notes, "anchor 4: the ranges say places up to 0.6 m apart")) << c.notes;
}

/// Columns that nobody has filled in, and those of one anchor that a radio does not know.
TEST(RangeTables, AnchorsThatAreNowhereAreNotSurveyed) {
  const std::string header = "t,anchor_id,range_m,anchor_x,anchor_y,anchor_z";
  Content c = read(rows(header, 6, [](int i) { return std::to_string(i % 2) + ",3.5,0,0,0"; }));
  EXPECT_EQ(c.ranges.size(), 6u) << c.notes;
  EXPECT_TRUE(c.standing.empty());
  EXPECT_TRUE(contains(c.notes, "every anchor that it is at 0 0 0")) << c.notes;
  c = read(rows(header, 6, [](int i) {
    return i % 2 == 0 ? std::string("4,3.5,99999,99999,99999") : std::string("5,4.5,,,");
  }));
  EXPECT_EQ(c.ranges.size(), 6u) << c.notes;
  EXPECT_TRUE(c.standing.empty());
}

/// Two tables: the robot's own, and what anchors have measured to one another.
Content readBoth(const std::string& between, const std::string& name = "anchor_ranges.csv",
                 const std::string& topics = "") {
  const test::TempFolder temp;
  test::writeText(temp.path() / "uwb.csv", rows("timestamp,anchor_id,range", 20, [](int i) {
                    return std::to_string(7 + i % 2) + ",4.5";
                  }));
  test::writeText(temp.path() / name, between);
  EurocOptions o;
  o.section = "csv";
  o.source = temp.path().string();
  o.topics = topics;
  Content c;
  Recording recording(findTables(o), o, &c.log);
  Event e;
  while (recording.next(&e)) {
    const auto* range = std::get_if<RangeRow>(&e.what);
    if (range == nullptr) continue;
    c.ranges.push_back(*range);
    c.labels.push_back(recording.rangeStreams()[e.stream].label);
  }
  for (const std::string& m : c.log.messages()) c.notes += m + "\n";
  return c;
}

TEST(RangeTables, WhatAnchorsMeasureToOneAnotherIsKeptApart) {
  const std::string table = rows("timestamp,from,to,range [mm],std [mm]", 10, [](int i) {
    return std::string(i % 2 == 0 ? "7,8" : "9,7") + ",6250,80";
  });
  for (const bool by_name : {true, false}) {
    const Content c = by_name
                          ? readBoth(table)
                          : readBoth(table, "links.csv", "range=uwb.csv anchor_range=links.csv");
    int own = 0, between = 0;
    for (std::size_t i = 0; i < c.ranges.size(); ++i) {
      const RangeRow& r = c.ranges[i];
      if (!r.from) {
        ++own;
        EXPECT_EQ(c.labels[i], "UWB0");
        continue;
      }
      EXPECT_EQ(c.labels[i], "");
      EXPECT_EQ(*r.from, between % 2 == 0 ? 7 : 9);
      EXPECT_EQ(r.anchor, between % 2 == 0 ? 8 : 7);
      EXPECT_DOUBLE_EQ(r.range_m, 6.25);
      EXPECT_DOUBLE_EQ(r.sigma_m, 0.08);
      ++between;
    }
    EXPECT_EQ(own, 20) << c.notes;
    EXPECT_EQ(between, 10) << c.notes;
    EXPECT_FALSE(contains(c.notes, "the robot's antennas are")) << c.notes;
  }
}

TEST(RangeTables, NamesOfAnchorsAreTheSameInBothTables) {
  const Content c = readBoth(rows("timestamp,from,to,range", 4, [](int) { return "7,gate,3.5"; }));
  int between = 0;
  std::optional<int> gate;
  for (const RangeRow& r : c.ranges) {
    if (!r.from) continue;
    ++between;
    EXPECT_EQ(*r.from, 7);
    EXPECT_EQ(r.anchor, gate.value_or(r.anchor));
    gate = r.anchor;
  }
  EXPECT_EQ(between, 4) << c.notes;
  EXPECT_TRUE(contains(c.notes, "anchor gate is " + std::to_string(gate.value_or(-1)))) << c.notes;
}

TEST(RangeTables, BetweenAnchorsWhatIsNoRangeIsSaid) {
  const Content c = readBoth(rows("timestamp,from,to,range", 4, [](int i) {
    return i == 0 ? "7,7,3.5" : i == 1 ? "7,8,-2" : "7,8,3.5";
  }));
  int between = 0;
  for (const RangeRow& r : c.ranges) between += r.from.has_value();
  EXPECT_EQ(between, 2) << c.notes;
  EXPECT_EQ(c.log.get("anchor_range_implausible"), 2) << c.notes;
  // Table, line, column, and what to do.
  const std::string what_to_do =
      "; a row needs a stamp, two different anchors and how far they are apart [m]: correct it, or "
      "leave it out";
  EXPECT_TRUE(contains(
      c.notes, "anchor_ranges.csv:2: columns 2 and 3: both ends are the anchor 7" + what_to_do))
      << c.notes;
  const auto first_problem = [](const std::string& row) {
    return readBoth(rows("timestamp,from,to,range", 4,
                         [&](int i) { return i == 1 ? row : std::string("7,8,3.5"); }))
        .notes;
  };
  for (const auto& [row, text] :
       {std::pair<std::string, std::string>{"7,8,-2", "column 4: a range of -2 m"},
        {"7,8,abc", "column 4: `abc` is not a number"},
        {",8,3.5", "column 2 is empty"},
        {"7,8 9,3.5", "column 3: `8 9` is no anchor's id"},
        {"7,8", "has 3 columns, needs 4"}}) {
    const std::string notes = first_problem(row);
    EXPECT_TRUE(contains(notes, "anchor_ranges.csv:3: " + text)) << notes;
    EXPECT_TRUE(contains(notes, what_to_do)) << notes;
  }
  EXPECT_THROW(readBoth(rows("timestamp,anchor,range", 4, [](int) { return "7,3.5"; })),
               InputError);
}

/// As UTIL's tables have them: idB less idA; and what is none.
TEST(RangeTables, DifferencesOfRanges) {
  const Content c = readBoth(rows("timestamp,idA,idB,tdoa_meas [mm]", 8,
                                  [](int i) {
                                    return i == 0   ? "7,7,250"
                                           : i == 1 ? "7,8,"
                                           : i == 2 ? "7,8,x"
                                           : i == 3 ? "7,8,1e12"
                                                    : "7,8,-1250";
                                  }),
                             "tdoa.csv");
  int own = 0, differences = 0;
  for (const RangeRow& r : c.ranges) {
    if (!r.reference) {
      ++own;
      continue;
    }
    ++differences;
    EXPECT_EQ(*r.reference, 7);
    EXPECT_EQ(r.anchor, 8);
    EXPECT_DOUBLE_EQ(r.range_m, -1.25);
  }
  EXPECT_EQ(own, 20) << c.notes;
  EXPECT_EQ(differences, 4) << c.notes;
  EXPECT_EQ(c.log.get("range_implausible"), 2) << c.notes;
  EXPECT_TRUE(contains(c.notes, "one and the same anchor")) << c.notes;
  EXPECT_TRUE(contains(c.notes, "less that to the one in column ida")) << c.notes;
}

}  // namespace
}  // namespace vir::euroc
