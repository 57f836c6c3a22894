#include "vir/tables/layout.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vir/tables/ranges.h"

namespace vir::tables {
namespace {

using Columns = std::vector<int>;

Columns gyroOf(const ImuColumns& c) { return {c.gyro[0], c.gyro[1], c.gyro[2]}; }
Columns accOf(const ImuColumns& c) { return {c.acc[0], c.acc[1], c.acc[2]}; }
Columns quatOf(const PoseColumns& c) { return {c.q[0], c.q[1], c.q[2], c.q[3]}; }

TEST(Layout, FindsSeparatorHeaderAndUnits) {
  const Layout a = layoutOfText("#timestamp [ns],w_RS_S_x [rad s^-1]\n1,2\n3,4\n");
  EXPECT_EQ(a.separator, ',');
  EXPECT_EQ(a.names, (std::vector<std::string>{"timestamp", "w_rs_s_x"}));
  EXPECT_EQ(a.units[1], "rad s^-1");
  EXPECT_EQ(a.columns, 2u);
  EXPECT_EQ(a.rows.size(), 2u);
  EXPECT_EQ(layoutOfText("t;x\r\n1;2\r\n").separator, ';');
  EXPECT_EQ(layoutOfText("t;x\r\n1;2\r\n").rows[0][1], "2");
  EXPECT_EQ(layoutOfText("1\t2\t3\n").separator, '\t');
  EXPECT_EQ(layoutOfText("1  2 3\n").columns, 3u);
  EXPECT_EQ(layoutOfText("\"t\",\"a x\"\n\"1\",\"2\"\n").names[1], "a_x");
  EXPECT_EQ(layoutOfText("").columns, 0u);
  EXPECT_EQ(layoutOf("/nonexistent").columns, 0u);
}

TEST(Layout, ImuByName) {
  const ImuColumns swapped =
      imuColumns(layoutOfText("timestamp,ax,ay,az,gx,gy,gz\n1,2,3,4,5,6,7\n"));
  EXPECT_TRUE(swapped.named);
  EXPECT_EQ(accOf(swapped), (Columns{1, 2, 3}));
  EXPECT_EQ(gyroOf(swapped), (Columns{4, 5, 6}));
  const ImuColumns pandas =
      imuColumns(layoutOfText(",timestamp,wx,wy,wz,ax,ay,az\n0,1,2,3,4,5,6,7\n1,2,3,4,5,6,7,8\n"));
  EXPECT_EQ(pandas.stamp, 1);
  EXPECT_EQ(gyroOf(pandas), (Columns{2, 3, 4}));
  const ImuColumns ros = imuColumns(
      layoutOfText("time,angular_velocity.x,angular_velocity.y,angular_velocity.z,"
                   "linear_acceleration.x,linear_acceleration.y,linear_acceleration.z\n1,2\n"));
  EXPECT_EQ(accOf(ros), (Columns{4, 5, 6}));
  const ImuColumns none = imuColumns(layoutOfText("1,2,3,4,5,6,7\n"));
  EXPECT_FALSE(none.named);
  EXPECT_EQ(accOf(none), (Columns{4, 5, 6}));
  // A header that leaves names out says nothing.
  EXPECT_EQ(gyroOf(imuColumns(layoutOfText("#timestamp,w_RS_S_x,...,a_RS_S_z\n1,2\n"))),
            (Columns{1, 2, 3}));
}

/// Behind the names, or in brackets behind the first of the three alone.
TEST(Layout, ImuWithUnitsInTheNames) {
  const ImuColumns c = imuColumns(
      layoutOfText("time,imu_gyro_x_dps,imu_gyro_y_dps,imu_gyro_z_dps,acc_x_g,acc_y_g,acc_z_g\n"
                   "1,0,0,0,0.1,0,1\n2,0,0,0,0.1,0,1\n"));
  ASSERT_TRUE(c.named);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(c.gyro[i], 1 + i);
    EXPECT_EQ(c.acc[i], 4 + i);
  }
  EXPECT_DOUBLE_EQ(c.gyro_unit, std::acos(-1.0) / 180);
  EXPECT_DOUBLE_EQ(c.acc_unit, 9.80665);
  const ImuColumns once = imuColumns(
      layoutOfText("t,gx [deg/s],gy,gz,ax [g],ay,az\n1,0,0,0,0.1,0,1\n2,0,0,0,0.1,0,1\n"));
  ASSERT_TRUE(once.named);
  EXPECT_DOUBLE_EQ(once.gyro_unit, std::acos(-1.0) / 180);
  EXPECT_DOUBLE_EQ(once.acc_unit, 9.80665);
}

TEST(Layout, PosesByNameAndByHabit) {
  EXPECT_EQ(quatOf(poseColumns(layoutOfText("#timestamp,x,y,z,qx,qy,qz,qw\n1,2,3,4,5,6,7,8\n"))),
            (Columns{4, 5, 6, 7}));
  EXPECT_EQ(quatOf(poseColumns(layoutOfText(
                "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
                "q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n1,2,3,4,5,6,7,8,9\n"))),
            (Columns{5, 6, 7, 4}));
  EXPECT_EQ(quatOf(poseColumns(layoutOfText("1,2,3,4,5,6,7,8\n"))), (Columns{5, 6, 7, 4}));
  EXPECT_EQ(quatOf(poseColumns(layoutOfText("1 2 3 4 5 6 7 8\n"))), (Columns{4, 5, 6, 7}));
  EXPECT_FALSE(poseColumns(layoutOfText("1,2,3,4\n")).hasAttitude());
  EXPECT_FALSE(
      poseColumns(
          layoutOfText("#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n1,2,3,4\n"))
          .hasAttitude());
  const PoseColumns counted = poseColumns(
      layoutOfText("num, t, x, y, z, qx, qy, qz, qw\n0, 1400000000.0, 1, 2, 3, 0, 0, 0, 1\n"));
  EXPECT_EQ(counted.stamp, 1);
  EXPECT_EQ(counted.p[0], 2);
  EXPECT_EQ(quatOf(counted), (Columns{5, 6, 7, 8}));
}

TEST(Layout, PositionsBySidesOfTheSky) {
  const auto columns = [](const std::string& names) {
    const PoseColumns c = poseColumns(layoutOfText("time," + names + "\n1,2,3,4\n"));
    return c.named ? Columns{c.p[0], c.p[1], c.p[2], c.down ? 1 : 0} : Columns{};
  };
  EXPECT_EQ(columns("easting,northing,altitude"), (Columns{1, 2, 3, 0}));
  EXPECT_EQ(columns("utm_easting [m],utm_northing [m],height [m]"), (Columns{1, 2, 3, 0}));
  EXPECT_EQ(columns("northing,easting,up"), (Columns{2, 1, 3, 0}));
  EXPECT_EQ(columns("east,north,up"), (Columns{1, 2, 3, 0}));
  EXPECT_EQ(columns("north,east,down"), (Columns{2, 1, 3, 1}));
  EXPECT_EQ(columns("north,east,speed"), Columns{});
}

TEST(Layout, NorthEastDownIsTurnedWithItsAttitude) {
  PoseColumns c = poseColumns(
      layoutOfText("time,north,east,down,qx,qy,qz,qw\n1,2,3,4,0,0,0,1\n2,2,3,4,0,0,0,1\n"));
  ASSERT_TRUE(c.down);
  double p[3] = {3, 2, 4}, q[4] = {0, 0, 0, 1};
  eastNorthUp(c, p, q);
  EXPECT_EQ(p[2], -4);
  // x of the body, which was north, is y now; its z, down, is -z.
  const double half = 0.70710678118654752;
  EXPECT_NEAR(q[0], half, 1e-15);
  EXPECT_NEAR(q[1], half, 1e-15);
  EXPECT_NEAR(q[2], 0, 1e-15);
  EXPECT_NEAR(q[3], 0, 1e-15);
  // A quarter turn from north to east in axes that point down: the body looks east.
  double turned[4] = {0, 0, half, half};
  eastNorthUp(c, p, turned);
  EXPECT_NEAR(turned[0], 1, 1e-15);
  EXPECT_NEAR(turned[1], 0, 1e-15);
}

TEST(Layout, AnIndexInFrontIsPassedOver) {
  EXPECT_EQ(stampColumn(layoutOfText("0,1400000000000000000,7\n1,1400000000050000000,7\n"
                                     "2,1400000000100000000,7\n")),
            1);
  // Seconds that count are stamps.
  EXPECT_EQ(stampColumn(layoutOfText("0 1 7\n1 2 7\n2 3 7\n")), 0);
}

TEST(Layout, ATemperatureIsNoTimeWhereThereIsOne) {
  const Layout log =
      layoutOfText("TimeUS,I,GyrX,GyrY,GyrZ,T\n1000,0,0.1,0,0,40.2\n3500,0,0.1,0,0,40.3\n");
  EXPECT_EQ(stampColumn(log), 0);
  EXPECT_EQ(stampColumn(layoutOfText("x,y,z,t\n1,2,3,0.1\n1,2,3,0.2\n")), 3);
}

TEST(Layout, SecondsAndTheirNanoseconds) {
  const Layout ros = layoutOfText("header.stamp.secs,header.stamp.nsecs,x\n0,5,1\n0,50000,1\n");
  EXPECT_EQ(stampColumn(ros), 0);
  EXPECT_EQ(nanosecondColumn(ros, 0), 1);
  EXPECT_EQ(stampUnit(ros, 0, 0.005).unit, StampUnit::seconds);
  EXPECT_EQ(nanosecondColumn(layoutOfText("sec,nanosec,x\n0,5,1\n"), 0), 1);
  EXPECT_EQ(nanosecondColumn(layoutOfText("nsec,x\n5,1\n"), 0), -1);
  EXPECT_EQ(nanosecondColumn(layoutOfText("5,1\n"), 0), -1);
}

TEST(Layout, CommasBesideSemicolonsAreDecimal) {
  EXPECT_EQ(layoutOfText("t;x\n1,5;2,5\n").separator, ';');
  EXPECT_EQ(layoutOfText("t;x\n1,5;2,5\n").rows[0][1], "2.5");
}

TEST(Layout, ColumnsOfRangesMayBeCalledAfterAnchors) {
  const auto anchors = [](const std::string& text) {
    std::string out;
    for (const AnchorColumn& a : rangeColumns(layoutOfText(text)).wide) out += a.anchor + ";";
    return out;
  };
  EXPECT_EQ(anchors("t,range_north,range_door\n1,2,3\n2,2,3\n"), "north;door;");
  EXPECT_EQ(anchors("t,distance_to_A,distance_to_B\n1,2,3\n2,2,3\n"), "A;B;");
  EXPECT_EQ(anchors("t,range_north,range_std\n1,2,3\n2,2,3\n"), "");
  EXPECT_EQ(anchors("t,range_1,range_std\n1,2,3\n2,2,3\n"), "1;");
}

TEST(Layout, ImagesAndRanges) {
  EXPECT_EQ(imageColumns(layoutOfText("#timestamp [ns],filename\n1,a.png\n")).file, 1);
  EXPECT_EQ(imageColumns(layoutOfText("#timestamp [ns],filename\n1\n")).file, -1);
  const RangeColumns r =
      rangeColumns(layoutOfText("#timestamp [ns],anchor_id,range [m],antenna\n1,2,3,4\n"));
  EXPECT_EQ(r.anchor, 1);
  EXPECT_EQ(r.range, 2);
  EXPECT_EQ(r.antenna, 3);
  EXPECT_EQ(rangeColumns(layoutOfText("stamp,distance,anchor\n1,2,3\n")).range, 1);
  EXPECT_EQ(rangeColumns(layoutOfText("1,2,3\n")).range, 2);
}

}  // namespace
}  // namespace vir::tables
