#include <gtest/gtest.h>

#include "vir/tables/layout.h"
#include "vir/tables/ranges.h"
#include "vir/tables/unknown_units.h"

namespace vir::tables {
namespace {

constexpr double kG = 9.80665, kDeg = 0.017453292519943295;

/// Of `t` and six columns, the accelerometer's about `size` long.
ImuColumns imu(const std::string& gyro, const std::string& acc, double size = 9.81) {
  std::string header = "t";
  for (const std::string& name : {gyro, acc}) {
    for (const char axis : {'x', 'y', 'z'}) {
      std::string column = name;
      column.replace(column.find('?'), 1, 1, axis);
      header += "," + column;
    }
  }
  return imuColumns(layoutOfText(header + "\n1,0,0,0,0,0," + std::to_string(size) + "\n"));
}

TEST(Units, OfTurningRates) {
  for (const char* name : {"gyro_? [deg/s]", "w?(deg/s)", "gyr_?_dps", "gyro_? (\xC2\xB0/s)",
                           "w?_deg_s", "g?[deg s^-1]", "gyro ? / (deg/s)", "gyro_?_in_deg_per_s",
                           "w?_deg/s", "gyroscope_? {degrees/second}"}) {
    const ImuColumns c = imu(name, "a?");
    EXPECT_TRUE(c.named) << name;
    EXPECT_DOUBLE_EQ(c.gyro_unit, kDeg) << name;
  }
  for (const char* name : {"gyro_? [mdps]", "gyr_?_mdps", "w? (mdeg/s)", "w?_mdeg_s"}) {
    EXPECT_DOUBLE_EQ(imu(name, "a?").gyro_unit, kDeg / 1000) << name;
  }
  for (const char* name : {"gyro_? [rad/s]", "w?", "w?_rad_s", "w? (rad s^-1)", "gyro_?_rps"}) {
    EXPECT_TRUE(imu(name, "a?").named) << name;
    EXPECT_DOUBLE_EQ(imu(name, "a?").gyro_unit, 1) << name;
  }
  EXPECT_DOUBLE_EQ(imu("w? [mrad/s]", "a?").gyro_unit, 1e-3);
}

TEST(Units, OfForces) {
  for (const char* name : {"acc_? (g)", "a?_g", "accel_? [G]", "acc? / g", "a?(g's)"}) {
    EXPECT_TRUE(imu("w?", name, 1).named) << name;
    EXPECT_DOUBLE_EQ(imu("w?", name, 1).acc_unit, kG) << name;
    EXPECT_DOUBLE_EQ(imu("w?", name, 9.81).acc_unit, 1) << name;
  }
  for (const char* name : {"acc_? (mg)", "a?_mg", "acc_? [milli-g]", "acc_?/mg"}) {
    EXPECT_DOUBLE_EQ(imu("w?", name, 1000).acc_unit, kG / 1000) << name;
    EXPECT_DOUBLE_EQ(imu("w?", name, 9.81).acc_unit, 1) << name;
  }
  EXPECT_DOUBLE_EQ(imu("w?", "a? [\xC2\xB5g]", 1e6).acc_unit, kG * 1e-6);
  EXPECT_DOUBLE_EQ(imu("w?", "a? [cm/s^2]", 981).acc_unit, 0.01);
  EXPECT_DOUBLE_EQ(imu("w?", "a? [mm/s2]", 9810).acc_unit, 0.001);
  for (const char* name : {"a? [m/s^2]", "a?_m_s2", "a? (m/s\xC2\xB2)", "a? [m s^-2]", "a?_mps2"}) {
    EXPECT_TRUE(imu("w?", name).named) << name;
    EXPECT_DOUBLE_EQ(imu("w?", name).acc_unit, 1) << name;
  }
}

TEST(Units, OfStamps) {
  const auto unit = [](const std::string& name) {
    return stampUnit(layoutOfText(name + ",x\n0,1\n500,1\n"), 0, 1).unit;
  };
  for (const char* name : {"time (ms)", "t [ms]", "time_ms", "t/ms", "Time since start in ms",
                           "timestamp [msec]", "elapsed_milliseconds"}) {
    EXPECT_EQ(unit(name), StampUnit::milliseconds) << name;
    EXPECT_EQ(namedStampColumn(layoutOfText("x," + std::string(name) + "\n1,2\n")), 1) << name;
  }
  for (const char* name :
       {"t [\xC2\xB5s]", "t (\xCE\xBCs)", "time_us", "t [\xB5s]", "time [usec]"}) {
    EXPECT_EQ(unit(name), StampUnit::microseconds) << name;
  }
  EXPECT_EQ(unit("time [s]"), StampUnit::seconds);
  EXPECT_EQ(stampUnit(layoutOfText("time_ns,x\n0,1\n5000,1\n"), 0, 1).unit, StampUnit::nanoseconds);
  EXPECT_EQ(stampColumn(layoutOfText("stamp_nsecs,stamp_secs,x\n1,2,3\n")), 1);
}

TEST(Units, OfLengthsAndWhatIsNoPosition) {
  EXPECT_DOUBLE_EQ(rangeColumns(layoutOfText("t,anchor,range [mm]\n1,2,3\n")).unit_m, 1e-3);
  EXPECT_DOUBLE_EQ(rangeColumns(layoutOfText("t,anchor,distance (cm)\n1,2,3\n")).unit_m, 1e-2);
  EXPECT_DOUBLE_EQ(poseColumns(layoutOfText("t,x / mm,y / mm,z / mm\n1,2,3,4\n")).unit_m, 1e-3);
  EXPECT_TRUE(poseColumns(layoutOfText("t,x [m],y [m],z [m]\n1,2,3,4\n")).named);
  EXPECT_FALSE(poseColumns(layoutOfText("t,x [mT],y [mT],z [mT]\n1,2,3,4\n")).named);
  const Layout force = layoutOfText("t [s],x [m/s^2],y [m/s^2],z [m/s^2]\n1,0,0,9.8\n");
  EXPECT_FALSE(poseColumns(force).named);
  EXPECT_TRUE(accelerometerColumns(force, false).named);
  EXPECT_FALSE(gyroColumns(force, true).named);
  EXPECT_TRUE(gyroColumns(layoutOfText("t,x (dps),y (dps),z (dps)\n1,0,0,9\n"), false).named);
}

TEST(Units, OfAMagnetometerAreNoMatter) {
  const ImuColumns c = imuColumns(layoutOfText(
      "time (ms),mx (mT),my (mT),mz (mT),acc_x (mg),acc_y (mg),acc_z (mg),gyro_x [mdps],"
      "gyro_y [mdps],gyro_z [mdps]\n1,2,3,4,0,0,1000,8,9,10\n"));
  EXPECT_TRUE(c.named);
  EXPECT_EQ(c.acc[0], 4);
  EXPECT_EQ(c.gyro[2], 9);
  EXPECT_DOUBLE_EQ(c.acc_unit, kG / 1000);
}

TEST(Units, OfAHeaderBetweenBlanks) {
  const Layout layout = layoutOfText("# t [s] wx [rad s^-1] wy (deg/s)\n1 2 3\n");
  EXPECT_EQ(layout.names, (std::vector<std::string>{"t", "wx", "wy"}));
  EXPECT_EQ(layout.units, (std::vector<std::string>{"s", "rad s^-1", "deg/s"}));
}

TEST(Units, TurnsPerMinuteAndWhatNobodyKnows) {
  const Layout turns = layoutOfText("t,gx [rpm],gy [rpm],gz [rpm],ax,ay,az\n1,2,3,4,0,0,9.81\n");
  EXPECT_NEAR(imuColumns(turns).gyro_unit, 2 * 3.14159265358979 / 60, 1e-12);
  const Layout layout = layoutOfText("t,anchor,range [furlong],std [mm]\n1,2,3,4\n");
  EXPECT_NE(unknownUnits(layout, {2, 3}).find("range [furlong]"), std::string::npos);
  EXPECT_EQ(unknownUnits(layout, {-1, 3}), "");
  EXPECT_EQ(unknownUnits(layoutOfText("1,2,3\n"), {2}), "");
}

TEST(Units, OfStampsThatNobodyKnowsAreSaid) {
  for (const std::string head :
       {"time [parsec]", "stamp(foo)", "t [ticks]", "Timestamp [0.1 ms]"}) {
    const Layout layout = layoutOfText(head + ",x,y,z\n0.00,1,2,3\n0.02,1,2,3\n0.04,1,2,3\n");
    const std::string said = unknownStampUnit(layout, stampColumn(layout), StampUnit::seconds);
    EXPECT_NE(said.find("known are s, ms, us and ns"), std::string::npos) << head;
    EXPECT_NE(said.find("taken to be in s:"), std::string::npos) << said;
  }
  for (const std::string head : {"time [s]", "stamp (msec)", "t [\xC2\xB5s]", "time [UTC]", "t [-]",
                                 "timestamp [nanoseconds]", "time", "time_ms"}) {
    const Layout layout = layoutOfText(head + ",x,y,z\n0.00,1,2,3\n0.02,1,2,3\n0.04,1,2,3\n");
    EXPECT_EQ(unknownStampUnit(layout, stampColumn(layout), StampUnit::seconds), "") << head;
  }
  const Layout dates = layoutOfText("time [ISO 8601],x\n2024-05-01T12:00:00.1Z,1\n");
  EXPECT_EQ(unknownStampUnit(dates, stampColumn(dates), StampUnit::seconds), "");
}

}  // namespace
}  // namespace vir::tables
