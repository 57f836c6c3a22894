#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "made_trajectories.h"
#include "vir/evaluation/trajectory.h"

namespace vir::evaluation {
namespace {

Trajectory tum(const std::string& text, ReadReport* report) {
  std::istringstream in(text);
  return readTum(in, report);
}

TEST(ParseSeconds, IsExactWhereADoubleIsNot) {
  TimeNs t = 0;
  ASSERT_TRUE(parseSeconds("1403636580.838555555", &t));
  EXPECT_EQ(t, 1403636580838555555);  // a double would be off by up to 119 ns
  ASSERT_TRUE(parseSeconds("1403636580.83856", &t));
  EXPECT_EQ(t, 1403636580838560000);
  ASSERT_TRUE(parseSeconds("1.403636580838555555e+09", &t));
  EXPECT_EQ(t, 1403636580838555555);
  ASSERT_TRUE(parseSeconds("14036365808385.55555E-4", &t));
  EXPECT_EQ(t, 1403636580838555555);
}

TEST(ParseSeconds, RoundsTheTenthDecimal) {
  TimeNs t = 0;
  ASSERT_TRUE(parseSeconds("0.0000000014", &t));
  EXPECT_EQ(t, 1);
  ASSERT_TRUE(parseSeconds("0.0000000015", &t));
  EXPECT_EQ(t, 2);
  ASSERT_TRUE(parseSeconds("0.0000000005", &t));
  EXPECT_EQ(t, 1);
  ASSERT_TRUE(parseSeconds("1.999999999999", &t));
  EXPECT_EQ(t, 2000000000);
  ASSERT_TRUE(parseSeconds("-1.0000000016", &t));
  EXPECT_EQ(t, -1000000002);
}

TEST(ParseSeconds, OddButValidForms) {
  TimeNs t = -1;
  for (const char* zero : {"0", "-0", "0.0", ".0", "0e5", "0.00000000000001", "1e-300"}) {
    ASSERT_TRUE(parseSeconds(zero, &t)) << zero;
    EXPECT_EQ(t, 0) << zero;
  }
  ASSERT_TRUE(parseSeconds("5.", &t));
  EXPECT_EQ(t, 5000000000);
  ASSERT_TRUE(parseSeconds("+.25", &t));
  EXPECT_EQ(t, 250000000);
  ASSERT_TRUE(parseSeconds("9223372036.854775807", &t));
  EXPECT_EQ(t, std::numeric_limits<TimeNs>::max());
}

TEST(ParseSeconds, RefusesTheRest) {
  TimeNs t = 0;
  for (const char* bad : {"", "-", ".", "e5", "1.2.3", "1s", "1e", "1e999999999999", "nan", "inf",
                          "0x10", "1403636580838555555", "9223372036.854775808", "1e18", "1 2"}) {
    EXPECT_FALSE(parseSeconds(bad, &t)) << bad;
  }
}

TEST(FormatSeconds, RoundTrip) {
  for (const TimeNs t : {TimeNs(0), TimeNs(1), TimeNs(-1), TimeNs(1403636580838555555),
                         TimeNs(-2000000001), std::numeric_limits<TimeNs>::max()}) {
    TimeNs back = 7;
    ASSERT_TRUE(parseSeconds(formatSeconds(t), &back));
    EXPECT_EQ(back, t);
  }
  EXPECT_EQ(formatSeconds(-5), "-0.000000005");
}

TEST(ReadTum, CommentsBlankLinesCrLfTabsAndBom) {
  ReadReport report;
  const Trajectory t =
      tum("\xEF\xBB\xBF# a head\r\n\r\n1.5 1 2 3 0 0 0 1\r\n   \t\n 2.5\t4  5 +6 0 0 1e0 0 # end\n",
          &report);
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].t, 1500000000);
  EXPECT_EQ(t[1].T_W_B.p, Vec3(4, 5, 6));
  EXPECT_EQ(t[1].T_W_B.q.z(), 1.0);
  EXPECT_EQ(report.poses, 2);
  EXPECT_EQ(report.skipped(), 0);
  EXPECT_TRUE(report.messages.empty());
}

TEST(ReadTum, BadLinesAreCountedAndNamed) {
  ReadReport report;
  const Trajectory t =
      tum("1 0 0 0 0 0 0 1\n"                    // 1 good
          "2 0 0 0 0 0 0\n"                      // 2 cut
          "x 0 0 0 0 0 0 1\n"                    // 3 stamp
          "4 0 abc 0 0 0 0 1\n"                  // 4 no number
          "5 nan 0 0 0 0 0 1\n"                  // 5 not finite
          "6 0 0 inf 0 0 0 1\n"                  // 6 not finite
          "7 0 0 0 0 0 0 0\n"                    // 7 zero quaternion
          "8 0 0 0 0 0 0 2\n"                    // 8 normalised
          "9 0 0 0 0 0 0 1 9\n"                  // 9 too long
          "1403636580838555555 0 0 0 0 0 0 1\n"  // 10 nanoseconds
          "11 1e999 0 0 0 0 0 1\n"               // 11 too large: not finite
          "12 0 0 0 0 0 0 1",                    // 12 good, no line end
          &report);
  ASSERT_EQ(t.size(), 3u);
  EXPECT_EQ(t[1].T_W_B.q.w(), 1.0);
  EXPECT_EQ(report.malformed, 5);
  EXPECT_EQ(report.not_finite, 3);
  EXPECT_EQ(report.zero_quaternions, 1);
  EXPECT_EQ(report.quaternions_normalised, 1);
  ASSERT_EQ(report.messages.size(), 6u);  // one for each kind
  EXPECT_EQ(report.messages[0],
            "line 2: expected 8 numbers, found 7 fields (and 1 more like this)");
  EXPECT_NE(report.messages[5].find("line 10"), std::string::npos);
  EXPECT_NE(report.messages[5].find("nanoseconds?"), std::string::npos);
}

TEST(ReadTum, OutOfOrderIsSortedAndRepeatedKeepsTheFirst) {
  ReadReport report;
  const Trajectory t =
      tum("3 3 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n1 9 0 0 0 0 0 1\n4 4 0 0 0 0 0 1\n",
          &report);
  ASSERT_EQ(t.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(t[i].T_W_B.p.x(), i + 1);
  EXPECT_EQ(report.out_of_order, 3);
  EXPECT_EQ(report.repeated, 1);
  ASSERT_EQ(report.messages.size(), 1u);
  EXPECT_EQ(report.messages[0].find("line 4:"), 0u);
}

TEST(ReadTum, OneMessageForAThousandOfAKind) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "rubbish\n";
  ReadReport report;
  EXPECT_TRUE(tum(text, &report).empty());
  EXPECT_EQ(report.malformed, 1000);
  ASSERT_EQ(report.messages.size(), 1u);
  EXPECT_NE(report.messages[0].find("999 more"), std::string::npos) << report.messages[0];
}

TEST(ReadTum, EmptyAndBinary) {
  ReadReport report;
  EXPECT_TRUE(tum("", &report).empty());
  EXPECT_TRUE(tum(std::string("\0\xff\x80 \0\n\0", 8), &report).empty());
  EXPECT_TRUE(tum("# only a comment", nullptr).empty());
}

TEST(ReadEuroc, OrderOfTheQuaternionAndFurtherColumns) {
  std::istringstream in(
      "#timestamp, p_RS_R_x [m], ...\r\n"
      "1403636580838555648,4.5,-1.5,0.75,0.5,-0.5,0.5,-0.5,9,9,9\r\n"
      "1403636580843555328, 4, -1, 0, 1, 0, 0, 0\r\n"
      "1403636580848555,4,-1\r\n");
  ReadReport report;
  const Trajectory t = readTrajectory(in, &report);
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].t, 1403636580838555648);
  EXPECT_EQ(t[0].T_W_B.p, Vec3(4.5, -1.5, 0.75));
  EXPECT_EQ(t[0].T_W_B.q.coeffs(), Eigen::Vector4d(-0.5, 0.5, -0.5, 0.5));  // x y z w
  EXPECT_EQ(report.malformed, 1);
  EXPECT_EQ(report.messages.at(0), "line 4: expected 8 numbers, found 3 fields");
}

Trajectory any(const std::string& text, ReadReport* report) {
  std::istringstream in(text);
  return readTrajectory(in, report);
}

/// The same pose in every way that people write it.
TEST(ReadTrajectory, AnyTable) {
  const StampedPose pose{1400000000050000000, Pose(Quat(0.5, -0.5, 0.5, 0.5), Vec3(1, -2, 3))};
  const std::vector<std::string> texts{
      "1400000000.05 1 -2 3 -0.5 0.5 0.5 0.5\n",
      "1.40000000005e+09 1.0e+00 -2e0 3 -5.0e-01 0.5 0.5 0.5\n",
      "1400000000050000000,1,-2,3,0.5,-0.5,0.5,0.5\n",
      "#timestamp,x,y,z,qx,qy,qz,qw\n1400000000050000000,1,-2,3,-0.5,0.5,0.5,0.5\n",
      "timestamp;x;y;z;qx;qy;qz;qw\n1400000000.05;1;-2;3;-0.5;0.5;0.5;0.5\n",
      "num, t, x, y, z, qx, qy, qz, qw\n0, 1400000000.05, 1, -2, 3, -0.5, 0.5, 0.5, 0.5\n",
      "1400000000.05,1,-2,3,-0.5,0.5,0.5,0.5\n",
      "1400000000.05\t1\t-2\t3\t-0.5\t0.5\t0.5\t0.5\n",
      "time_ms,x,y,z,qx,qy,qz,qw\n1400000000050.000000,1,-2,3,-0.5,0.5,0.5,0.5\n",
      "secs,nsecs,x,y,z,qx,qy,qz,qw\n1400000000,50000000,1,-2,3,-0.5,0.5,0.5,0.5\n",
      "t,x [mm],y [mm],z [mm],qx,qy,qz,qw\n1400000000.05,1000,-2000,3000,-0.5,0.5,0.5,0.5\n",
      "t,x,y,z,q0,q1,q2,q3\n1400000000.05,1,-2,3,0.5,-0.5,0.5,0.5\n",
      "t_ms\tpx\tpy\tpz\tqw\tqx\tqy\tqz\n1400000000050\t1\t-2\t3\t0.5\t-0.5\t0.5\t0.5\n"};
  for (const std::string& text : texts) {
    ReadReport report;
    const Trajectory t = any(text, &report);
    ASSERT_EQ(t.size(), 1u) << text;
    EXPECT_EQ(t[0].t, pose.t) << text;
    EXPECT_EQ(t[0].T_W_B.p, pose.T_W_B.p) << text;
    EXPECT_EQ(t[0].T_W_B.q.coeffs(), pose.T_W_B.q.coeffs()) << text;
    EXPECT_FALSE(report.positions_only);
    EXPECT_EQ(report.skipped(), 0) << text;
  }
}

/// Programs that write seconds have the attitude in TUM's order, whatever separates the numbers.
TEST(ReadTrajectory, WithoutAHeaderTheOrderIsTakenFromTheStampsAndSaid) {
  const Quat q(0.1, 0.5, -0.7, 0.5);
  for (const bool seconds : {true, false}) {
    ReadReport report;
    const Trajectory t = any(seconds ? "1400000000.05,1,-2,3,0.5,-0.7,0.5,0.1\n"
                                     : "1400000000050000000,1,-2,3,0.1,0.5,-0.7,0.5\n",
                             &report);
    ASSERT_EQ(t.size(), 1u);
    EXPECT_EQ(t[0].t, 1400000000050000000);
    EXPECT_LT(t[0].T_W_B.q.angularDistance(q), 1e-12);
    ASSERT_FALSE(report.notes.empty());
    EXPECT_NE(report.notes[0].find(seconds ? "qx qy qz qw" : "qw qx qy qz"), std::string::npos)
        << report.notes[0];
  }
}

TEST(ReadTrajectory, SaysWhyATableHoldsNoPoses) {
  const std::vector<std::pair<const char*, const char*>> tables{
      {"t,latitude,longitude,altitude\n1400000000.05,47.1,8.2,400\n", "latitude and longitude"},
      {"1 0 0 7.5 0 1 0 2 0 0 1 -3\n1 0 0 7.6 0 1 0 2 0 0 1 -3\n", "KITTI"}};
  for (const auto& [text, why] : tables) {
    ReadReport report;
    EXPECT_TRUE(any(text, &report).empty()) << text;
    ASSERT_EQ(report.notes.size(), 1u) << text;
    EXPECT_NE(report.notes[0].find(why), std::string::npos) << report.notes[0];
  }
}

TEST(ReadTrajectory, DecimalCommasDatesAndAngles) {
  ReadReport report;
  const Trajectory t = any(
      "t;x;y;z;yaw [deg];roll [deg];pitch [deg]\n2014-05-13 16:53:20,05;1,5;2;3;90;0;0\n", &report);
  ASSERT_EQ(t.size(), 1u);
  EXPECT_EQ(t[0].t, 1400000000050000000);
  EXPECT_EQ(t[0].T_W_B.p, Vec3(1.5, 2, 3));
  EXPECT_LT(t[0].T_W_B.q.angularDistance(Quat(std::sqrt(0.5), 0, 0, std::sqrt(0.5))), 1e-12);
  ASSERT_EQ(report.notes.size(), 3u);  // the unit of the stamps, dates, angles
}

/// Columns are not taken by their place where a header says what they are.
TEST(ReadTrajectory, AHeaderThatNamesNoPositionIsNotGuessedAt) {
  for (const char* header : {"timestamp,x,y,yaw", "time,seconds_elapsed,qz,qy,qx,qw,roll,pitch"}) {
    std::string text = std::string(header) + "\n";
    for (int k = 0; k < 20; ++k) {
      text += std::to_string(1.4e9 + 0.1 * k) + ",1,2,0.3" +
              (std::string(header).size() > 20 ? ",0,0,0,1" : "") + "\n";
    }
    std::istringstream in(text);
    ReadReport report;
    EXPECT_TRUE(readTrajectory(in, &report).empty()) << header;
    ASSERT_FALSE(report.notes.empty());
    bool said = false;
    for (const std::string& n : report.notes) {
      said = said || n.find("its header names no x, y and z") != std::string::npos;
    }
    EXPECT_TRUE(said) << header;
  }
}

TEST(ReadTrajectory, PositionsAlone) {
  ReadReport report;
  const Trajectory t =
      any("#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n"
          "1400000000050000000,1,-2,2553112.0167\n",
          &report);
  ASSERT_EQ(t.size(), 1u);
  EXPECT_TRUE(report.positions_only);
  EXPECT_EQ(t[0].T_W_B.p.z(), 2553112.0167);
}

TEST(WriteTum, RoundTripKeepsStampsAndNineDecimals) {
  const Trajectory made = test::winding(2, 20);
  std::ostringstream out;
  writeTum(out, made);
  ReadReport report;
  const Trajectory back = tum(out.str(), &report);
  ASSERT_EQ(back.size(), made.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(back[i].t, made[i].t);
    EXPECT_LT((back[i].T_W_B.p - made[i].T_W_B.p).norm(), 1e-9);
    EXPECT_LT(back[i].T_W_B.q.angularDistance(made[i].T_W_B.q), 1e-8);
  }
  EXPECT_EQ(tumLine({1500000001, Pose(Quat(1, 0, 0, 0), Vec3(1, -2, 0.5))}),
            "1.500000001 1.000000000 -2.000000000 0.500000000 0.000000000 0.000000000 0.000000000 "
            "1.000000000");
}

TEST(ReadTum, PosesBeforeAChangeOfFrameAreGivenInTheLastOne) {
  const Pose a(Quat(Eigen::AngleAxisd(0.5, Vec3::UnitZ())), Vec3(1, 2, 3)),
      b(Quat(Eigen::AngleAxisd(-2, Vec3::UnitZ())), Vec3(-7, 0, 1));
  const Pose pose(Quat::Identity(), Vec3(0.25, 0.5, 0));
  const auto line = [&](TimeNs t) { return tumLine({t, pose}) + "\n"; };
  ReadReport report;
  const Trajectory t =
      tum(line(1) + frameChangeLine(a) + "\n" + line(2) + frameChangeLine(b) + "\r\n" + line(3),
          &report);
  ASSERT_EQ(t.size(), 3u);
  EXPECT_LT((t[0].T_W_B.p - (b * a * pose).p).norm(), 1e-8);
  EXPECT_LT((t[1].T_W_B.p - (b * pose).p).norm(), 1e-8);
  EXPECT_EQ(t[2].T_W_B.p, pose.p);
}

TEST(ReadTum, ADamagedChangeOfFrameIsCountedAndSaid) {
  const std::string begin = frameChangeLine(Pose()).substr(0, frameChangeLine(Pose()).find(" 0."));
  const std::string end = "\n2 0 0 0 0 0 0 1\n";
  for (const char* numbers : {"", " 1 2 3", " 1 2 3 0 0 0 2", " nan 2 3 0 0 0 1",
                              " 1e300 2 3 0 0 0 1", " 1 2 x 0 0 0 1"}) {
    ReadReport report;
    const Trajectory t = tum("1 0 0 0 0 0 0 1\n" + begin + numbers + end, &report);
    ASSERT_EQ(t.size(), 2u) << numbers;
    EXPECT_EQ(t[0].T_W_B.p, Vec3::Zero()) << numbers;
    EXPECT_EQ(report.malformed, 1) << numbers;
    EXPECT_EQ(report.skipped(), 1) << numbers;
    ASSERT_EQ(report.messages.size(), 1u) << numbers;
    EXPECT_EQ(report.messages[0].rfind("line 2: ", 0), 0u) << report.messages[0];
    EXPECT_NE(report.messages[0].find("another frame"), std::string::npos) << report.messages[0];
  }
  ReadReport cut;
  EXPECT_EQ(tum("1 0 0 0 0 0 0 1\n" + begin.substr(0, begin.size() - 8) + end, &cut).size(), 2u);
  EXPECT_EQ(cut.malformed, 1);
  ReadReport comment;
  EXPECT_EQ(tum("1 0 0 0 0 0 0 1\n# of another frame" + end, &comment).size(), 2u);
  EXPECT_EQ(comment.skipped(), 0);
}

TEST(ReadStamps, TakesTheFirstColumn) {
  std::istringstream in("#timestamp [ns],filename\r\n30,30.png\r\n\r\n10,10.png\r\nt,x\r\n20\r\n");
  EXPECT_EQ(readStamps(in), (std::vector<TimeNs>{10, 20, 30}));
}

}  // namespace
}  // namespace vir::evaluation
