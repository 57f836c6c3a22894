/// Columns that must not be taken for what they look like, and what is said of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "vir/tables/layout.h"
#include "vir/tables/ranges.h"
#include "vir_test_temp_folder.h"

namespace vir::tables {
namespace {

bool says(const RangeColumns& columns, const std::string& part) {
  return std::any_of(columns.remarks.begin(), columns.remarks.end(),
                     [&](const std::string& remark) { return remark.find(part) != remark.npos; });
}

TEST(DoubtfulColumns, TimesOfFlightNeedAUnit) {
  const std::string rows = "\n0.1,7,33.3\n0.2,8,66.7\n";
  const Layout bare = layoutOfText("t,anchor_id,tof" + rows);
  EXPECT_NE(rangeColumns(bare).refusal.find("without a unit"), std::string::npos);
  EXPECT_FALSE(rangeColumns(bare).named);
  EXPECT_EQ(whyNoRanges(bare), rangeColumns(bare).refusal);
  const double light_m_per_s = 299702547;  // in air
  const struct {
    const char* column;
    double seconds;
  } cases[] = {{"tof [ns]", 1e-9},
               {"tof_ps", 1e-12},
               {"flight_time [us]", 1e-6},
               {"tof_ms", 1e-3},
               {"tof [s]", 1}};
  for (const auto& c : cases) {
    const RangeColumns columns =
        rangeColumns(layoutOfText(std::string("t,anchor_id,") + c.column + rows));
    EXPECT_TRUE(columns.named && columns.flight) << c.column;
    EXPECT_EQ(columns.refusal, "") << c.column;
    EXPECT_NEAR(columns.unit_m, light_m_per_s * c.seconds, 1e-9 * light_m_per_s * c.seconds)
        << c.column;
    EXPECT_TRUE(says(columns, "one way")) << c.column;
  }
}

TEST(DoubtfulColumns, DifferencesOfRangesAreNoRanges) {
  const RangeColumns columns =
      rangeColumns(layoutOfText("t,id_a,id_b,tdoa\n0.1,1,2,-0.5\n0.2,1,3,0.7\n"));
  EXPECT_EQ(columns.reference, 1);
  EXPECT_EQ(columns.anchor, 2);
  EXPECT_EQ(columns.range, 3);
  EXPECT_EQ(columns.last(), 3);
  EXPECT_TRUE(says(columns, "TDoA"));
}

/// An anchor that is out of reach for the first minute, in a small file and in a large one.
TEST(DoubtfulColumns, AnAnchorThatIsHeardLaterIsAnAnchor) {
  for (const int rows : {400, 20000}) {
    std::string text = "timestamp,range_1,range_2,range_3\n";
    for (int i = 0; i < rows; ++i) {
      text += std::to_string(i) + "." + std::to_string(i % 10) + ",2.5," +
              (i < rows * 2 / 3 ? ",nan" : "3.5,4.5") + "\n";
    }
    const test::TempFolder folder;
    test::writeText((folder / "ranges.csv").string(), text);
    const RangeColumns columns = rangeColumns(layoutOf((folder / "ranges.csv").string()));
    EXPECT_EQ(columns.wide.size(), 3u) << rows;
  }
}

TEST(DoubtfulColumns, TheEndWithMoreNamesIsTheAnchor) {
  const RangeColumns robot_first =
      rangeColumns(layoutOfText("t,src,dst,range\n1,9,1,2.5\n2,9,2,3.5\n3,9,3,4\n"));
  EXPECT_EQ(robot_first.anchor, 2);
  EXPECT_EQ(robot_first.antenna, 1);
  const RangeColumns anchor_first =
      rangeColumns(layoutOfText("t,src,dst,range\n1,1,9,2.5\n2,2,9,3.5\n3,3,9,4\n"));
  EXPECT_EQ(anchor_first.anchor, 1);
  EXPECT_EQ(anchor_first.antenna, 2);
  EXPECT_TRUE(says(anchor_first, "fewer values"));
}

/// A file's first 64 kB know one anchor, the others come later.
TEST(DoubtfulColumns, LaterRowsAreAskedToo) {
  const test::TempFolder folder;
  std::string text = "t,src,dst,range\n";
  for (int i = 0; i < 20'000; ++i) {
    text += std::to_string(i) + "," + std::to_string(i < 10'000 ? 1 : 1 + i % 7) + "," +
            std::to_string(9 - i % 2) + ",2.5\n";
  }
  test::writeText(folder / "ranges.csv", text);
  const Layout layout = layoutOf((folder / "ranges.csv").string());
  EXPECT_GE(layout.later.size(), 60u);
  EXPECT_EQ(rangeColumns(layout).anchor, 1);
  EXPECT_EQ(rangeColumns(layoutOfText(text.substr(0, 60'000))).anchor, 2);
}

/// A robot that stands level and turns away later.
TEST(DoubtfulColumns, AnglesOfLaterRowsSayThatTheyAreDegrees) {
  const test::TempFolder folder;
  std::string text = "t,x,y,z,roll,pitch,yaw\n";
  for (int i = 0; i < 20'000; ++i) {
    text += std::to_string(i) + ",1,2,3,0.5,0.5," + (i < 10'000 ? "1.5" : "150") + "\n";
  }
  test::writeText(folder / "truth.csv", text);
  EXPECT_NEAR(poseColumns(layoutOf((folder / "truth.csv").string())).angle_unit,
              0.017453292519943295, 1e-15);
}

TEST(DoubtfulColumns, AnAntennaStaysOnTheRobot) {
  const std::string header = "t,anchor_id,range,tag_x,tag_y,tag_z\n";
  const RangeColumns near =
      rangeColumns(layoutOfText(header + "1,1,2,0.1,0,0.2\n2,1,2,0.1,0,0.2\n"));
  EXPECT_EQ(near.lever[0], 3);
  EXPECT_EQ(near.last(), 5);
  const RangeColumns far = rangeColumns(layoutOfText(header + "1,1,2,11,0,0.2\n"));
  EXPECT_FALSE(far.hasLever());
  EXPECT_TRUE(says(far, "are not used: an antenna"));
  std::string moving = header;
  for (int i = 0; i < 9; ++i)
    moving += std::to_string(i) + ",1,2,0." + std::to_string(i) + ",0,0\n";
  EXPECT_FALSE(rangeColumns(layoutOfText(moving)).hasLever());
}

TEST(DoubtfulColumns, ANoiseIsOfAPlausibleSize) {
  const auto columns = [](const std::string& name, const std::string& value) {
    return rangeColumns(
        layoutOfText("t,anchor_id,range," + name + "\n1,1,2," + value + "\n2,1,2," + value + "\n"));
  };
  EXPECT_EQ(columns("std", "0.1").sigma, 3);
  for (const char* value : {"50", "1e-4"}) {
    EXPECT_EQ(columns("std", value).sigma, -1) << value;
    EXPECT_TRUE(says(columns("std", value), "name its unit")) << value;
  }
  EXPECT_EQ(columns("std [mm]", "50").sigma, 3);
  EXPECT_DOUBLE_EQ(columns("std [mm]", "50").sigma_unit_m, 1e-3);
  EXPECT_EQ(columns("std [rad]", "0.1").sigma, -1);
}

TEST(DoubtfulColumns, RowsThatSayThatTheyAreNoneAreNamed) {
  const RangeColumns columns =
      rangeColumns(layoutOfText("t,anchor_id,range,valid\n1,1,2,0\n2,1,2,1\n"));
  EXPECT_EQ(columns.valid, 3);
  EXPECT_TRUE(says(columns, "left out and counted"));
}

TEST(DoubtfulColumns, DegreesAndKittisPosesAreNoPositions) {
  EXPECT_NE(
      whyNoPoses(layoutOfText("t,latitude,longitude,altitude\n1,47.1,8.5,400\n")).find("latitude"),
      std::string::npos);
  const std::string kitti = "1 0 0 5 0 1 0 6 0 0 1 7\n";
  EXPECT_NE(whyNoPoses(layoutOfText(kitti)).find("KITTI"), std::string::npos);
  // No rotation is in it.
  EXPECT_EQ(whyNoPoses(layoutOfText("1 0 0 5 0 2 0 6 0 0 1 7\n")), "");
}

TEST(DoubtfulColumns, ImagesAreFoundByTheirNames) {
  const ImageColumns behind = imageColumns(layoutOfText("1,3,img/0001.PNG\n2,3,img/0002.PNG\n"));
  EXPECT_TRUE(behind.by_content);
  EXPECT_EQ(behind.file, 2);
  const ImageColumns front = imageColumns(layoutOfText("0001.jpg,100.5\n0002.jpg,100.6\n"));
  EXPECT_EQ(front.file, 0);
  EXPECT_EQ(front.stamp, 1);
  EXPECT_FALSE(imageColumns(layoutOfText("1,0001\n2,0002.txt\n")).by_content);
}

}  // namespace
}  // namespace vir::tables
