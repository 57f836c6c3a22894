/// Headers whose names nobody here knows, and those of `rostopic echo -p`.
#include <gtest/gtest.h>

#include "vir/tables/by_position.h"
#include "vir/tables/layout.h"
#include "vir/tables/ranges.h"

namespace vir::tables {
namespace {

constexpr double kG = 9.80665, kDeg = 0.017453292519943295;

TEST(UnknownNames, UnitsTellForceFromTurning) {
  // The degree sign is that of Latin-1.
  const Layout layout = layoutOfText(
      "Zeit [ms];Beschl X [g];Beschl Y [g];Beschl Z [g];Drehrate X [\xB0/s];Drehrate Y [\xB0/s];"
      "Drehrate Z [\xB0/s]\n1000;0,01;0,02;1,0;1,5;2,5;3,5\n1005;0,01;0,02;1,0;1,5;2,5;3,5\n");
  const ImuColumns c = imuColumns(layout);
  EXPECT_FALSE(c.named);
  EXPECT_TRUE(c.by_units);
  EXPECT_EQ(c.acc[0], 1);
  EXPECT_EQ(c.acc[2], 3);
  EXPECT_EQ(c.gyro[0], 4);
  EXPECT_EQ(c.gyro[2], 6);
  EXPECT_DOUBLE_EQ(c.gyro_unit, kDeg);
  EXPECT_DOUBLE_EQ(c.acc_unit, kG);
  Taken taken;
  addAxes(c.acc, "accelerometer", &taken);
  EXPECT_EQ(takenByPosition(layout, taken, true),
            "the names of its columns are not known; taken by their units: Beschl X [g] as "
            "accelerometer x, Beschl Y [g] as accelerometer y, Beschl Z [g] as accelerometer z");
  taken = {{4, "gyro x"}};
  EXPECT_EQ(takenByPosition(layout, taken, true),
            "the names of its columns are not known; taken by their units: Drehrate X "
            "[\xC2\xB0/s] as gyro x");
}

TEST(UnknownNames, UnitsOfOneOfTheTwoAreEnough) {
  const ImuColumns c = imuColumns(
      layoutOfText("Zeit,u,v,w,p [deg/s],q [deg/s],r [deg/s]\n1,0,0,9.8,1,2,3\n2,0,0,9.8,1,2,3\n"));
  EXPECT_TRUE(c.by_units);
  EXPECT_EQ(c.gyro[0], 4);
  EXPECT_EQ(c.acc[0], 1);
  EXPECT_DOUBLE_EQ(c.gyro_unit, kDeg);
  // Where they stand as usual the place decides, and the unit counts.
  const ImuColumns usual =
      imuColumns(layoutOfText("Zeit,p [mdeg/s],q [mdeg/s],r [mdeg/s],i [mg],j [mg],k [mg],l [mg]\n"
                              "1,1,2,3,0,0,1000,5\n2,1,2,3,0,0,1000,5\n"));
  EXPECT_FALSE(usual.by_units);
  EXPECT_EQ(usual.gyro[0], 1);
  EXPECT_DOUBLE_EQ(usual.gyro_unit, kDeg / 1000);
  EXPECT_DOUBLE_EQ(usual.acc_unit, kG / 1000);
}

TEST(UnknownNames, PositionIsSaid) {
  const Layout layout = layoutOfText("Zeit;Anker;Entfernung [cm]\n1,0;3;250\n1,1;4;310\n");
  const RangeColumns c = rangeColumns(layout);
  EXPECT_FALSE(c.named);
  EXPECT_EQ(c.range, 2);
  EXPECT_DOUBLE_EQ(c.unit_m, 0.01);
  EXPECT_EQ(takenByPosition(layout, {{c.stamp, "stamp"}, {c.anchor, "anchor"}, {c.range, "range"}}),
            "the names of its columns are not known; taken by position: Zeit as stamp, Anker as "
            "anchor, Entfernung [cm] as range; name them as in `t,gyro_x,...` if that is wrong");
  // The unit of a length tells which of the two it is.
  const RangeColumns turned =
      rangeColumns(layoutOfText("Zeit;Entfernung [cm];Anker\n1,0;250;3\n1,1;310;4\n"));
  EXPECT_EQ(turned.range, 1);
  EXPECT_EQ(turned.anchor, 2);
  EXPECT_DOUBLE_EQ(turned.unit_m, 0.01);
}

TEST(UnknownNames, ARemarkIsNoHeader) {
  for (const char* text : {"1,2,3\n4,5,6\n", "# flight of the blue one, at noon\n1 2 3\n4 5 6\n",
                           "# the blue one\n1 2 3\n4 5 6\n", "# two, words\n1,2,3\n4,5,6\n"}) {
    EXPECT_FALSE(hasHeader(layoutOfText(text))) << text;
    EXPECT_EQ(takenByPosition(layoutOfText(text), {{0, "stamp"}}), "") << text;
  }
  EXPECT_TRUE(hasHeader(layoutOfText("# Zeit, Anker, Weite\n1,2,3\n4,5,6\n")));
  EXPECT_TRUE(hasHeader(layoutOfText("Zeit Anker Weite [cm]\n1 2 3\n4 5 6\n")));
}

const char* const kFront = "%time,field.header.seq,field.header.stamp,field.header.frame_id,";

TEST(RostopicEcho, StampsAreThoseOfTheHeader) {
  const Layout layout = layoutOfText(
      std::string(kFront) +
      "field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,"
      "field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z\n"
      "1403636580013555456,1,1403636580003555456,imu,1,2,3,4,5,6\n"
      "1403636580018555456,2,1403636580008555456,imu,1,2,3,4,5,6\n");
  const ImuColumns c = imuColumns(layout);
  EXPECT_TRUE(c.named);
  EXPECT_EQ(c.stamp, 2);
  EXPECT_EQ(c.gyro[0], 4);
  EXPECT_EQ(c.acc[0], 7);
  EXPECT_EQ(stampUnit(layout, c.stamp, 0.005).unit, StampUnit::nanoseconds);
  EXPECT_EQ(stampRemark(layout, c.stamp),
            "the stamps are those of header.stamp, not of time, when it was received; in ns");
}

TEST(RostopicEcho, AStampThatStandsIsNone) {
  const Layout layout = layoutOfText(std::string(kFront) +
                                     "field.anchor_id,field.distance\n"
                                     "1403636580013555456,1,0,uwb,7,2.5\n"
                                     "1403636580018555456,2,0,uwb,8,2.5\n");
  const RangeColumns c = rangeColumns(layout);
  EXPECT_TRUE(c.named);
  EXPECT_EQ(c.stamp, 0);
  EXPECT_EQ(c.anchor, 4);
  EXPECT_EQ(c.range, 5);
}

TEST(RostopicEcho, Transforms) {
  const PoseColumns c = poseColumns(layoutOfText(
      std::string(kFront) +
      "field.child_frame_id,field.transform.translation.x,field.transform.translation.y,"
      "field.transform.translation.z,field.transform.rotation.x,field.transform.rotation.y,"
      "field.transform.rotation.z,field.transform.rotation.w\n"
      "1403636580013555456,1,1403636580003555456,world,drone,1,2,3,0,0,0,1\n"
      "1403636580018555456,2,1403636580008555456,world,drone,1,2,3,0,0,0,1\n"));
  EXPECT_TRUE(c.named);
  EXPECT_EQ(c.stamp, 2);
  EXPECT_EQ(c.p[0], 5);
  EXPECT_EQ(c.q[0], 8);
  EXPECT_EQ(c.q[3], 11);
}

}  // namespace
}  // namespace vir::tables
