/// One robot's part of a graph: odometry put together, whose ranges are whose.
#include "robot_recording.h"

#include <gtest/gtest.h>

#include "vir/core/settings.h"
#include "vir_test_data.h"
#include "vir_test_pyfg.h"
#include "vir_test_temp_folder.h"

namespace vir::pyfg {
namespace {

class Recording : public ::testing::Test {
 protected:
  RobotRecording extract(const std::string& text, const std::string& robot = "A") {
    log = {};
    test::writeText(folder / "g.pyfg", text);
    options.robot = robot;
    return extractRobot(readGraph((folder / "g.pyfg").string(), &log), options, &log);
  }
  std::string said() const {
    std::string all;
    for (const auto& m : log.messages()) all += m + "\n";
    return all;
  }
  template <typename What>
  static std::vector<std::pair<TimeNs, What>> only(const RobotRecording& r) {
    std::vector<std::pair<TimeNs, What>> out;
    for (const Event& e : r.events) {
      if (const auto* what = std::get_if<What>(&e.what)) out.emplace_back(e.t, *what);
    }
    return out;
  }
  static bool ordered(const RobotRecording& r) {
    return std::is_sorted(r.events.begin(), r.events.end(),
                          [](const Event& a, const Event& b) { return a.t < b.t; });
  }

  test::TempFolder folder;
  ProblemLog log;
  PyfgOptions options;
};

constexpr TimeNs kSecond = 1'000'000'000;

TEST_F(Recording, EveryKindOfOneRobotInTimeOrder) {
  for (const std::string robot : {"A", "B"}) {
    const RobotRecording r = extract(test::twoRobots(5), robot);
    EXPECT_TRUE(ordered(r));
    EXPECT_EQ(only<TruePose>(r).size(), 5u);
    const auto odometry = only<OdometryPose>(r);
    ASSERT_EQ(odometry.size(), 5u);
    EXPECT_EQ(odometry[0].first, 100 * kSecond);
    EXPECT_TRUE(odometry[0].second.T_O_B.p.isZero());
    EXPECT_TRUE(odometry[4].second.T_O_B.p.isApprox(Vec3(4, 0, 0), 1e-9));
    const auto ranges = only<AnchorRange>(r);
    ASSERT_EQ(ranges.size(), 5u);
    EXPECT_EQ(ranges[1].second.anchor, 7);
    EXPECT_DOUBLE_EQ(ranges[1].second.range_m, 4);
    EXPECT_DOUBLE_EQ(ranges[1].second.sigma_m, 0.05);
    const auto peers = only<PeerRange>(r);
    ASSERT_EQ(peers.size(), 5u) << "whichever is named first";
    EXPECT_EQ(peers[3].second.peer, robot == "A" ? 1 : 0);
    EXPECT_EQ(log.get("ranges_of_others"), 5);
    EXPECT_EQ(said(), "");
  }
}

TEST_F(Recording, TheRobotMustBeNamedWhereThereAreSeveral) {
  for (const std::string wrong : {"", "C", "a", "AB"}) {
    try {
      extract(test::twoRobots(3), wrong);
      ADD_FAILURE() << wrong;
    } catch (const SettingsError& e) {
      EXPECT_NE(std::string(e.what()).find("A, B"), std::string::npos) << e.what();
    }
  }
  EXPECT_EQ(extract("VERTEX_SE2 1 Q0 0 0 0\n", "").robot, 'Q');
}

TEST_F(Recording, MotionsTurnWithTheRobot) {
  std::string text = test::vertex2('A', 0, 10, 0, 0, 0.3);
  for (int i = 0; i < 4; ++i) text += test::motion2('A', i, i + 1, 11 + i, 1, 0, M_PI / 2);
  const auto path = only<OdometryPose>(extract(text));
  ASSERT_EQ(path.size(), 5u);
  EXPECT_TRUE(path[1].second.T_O_B.p.isApprox(Vec3(1, 0, 0), 1e-8));
  EXPECT_TRUE(path[2].second.T_O_B.p.isApprox(Vec3(1, 1, 0), 1e-8));
  EXPECT_LT(path[4].second.T_O_B.p.norm(), 1e-8);
  EXPECT_LT(logQuat(path[4].second.T_O_B.q).norm(), 1e-8) << "the true heading is not used";
  // Facing +y, what was known to 0.2 m ahead and 0.3 m across lies along y and x.
  const Mat6& c = path[2].second.step_covariance;
  EXPECT_NEAR(c(1, 1), 0.04, 1e-9);
  EXPECT_NEAR(c(0, 0), 0.09, 1e-9);
  EXPECT_NEAR(c(5, 5), 0.01, 1e-12);
  EXPECT_NEAR(c(2, 2), 1e-6, 1e-12) << "planar_sigma_z_m";
  EXPECT_TRUE(path[0].second.step_covariance.isZero());
}

TEST_F(Recording, TheMotionsStampIsTheOdometrys) {
  const auto path = only<OdometryPose>(extract(test::vertex2('A', 0, 10, 0, 0, 0) +
                                               test::vertex2('A', 1, 11, 0, 0, 0) +
                                               test::motion2('A', 0, 1, 11.125, 1, 0, 0)));
  ASSERT_EQ(path.size(), 2u);
  EXPECT_EQ(path[1].first, 11 * kSecond + kSecond / 8);
}

TEST_F(Recording, AMissingMotionIsAGapOfUnknownSize) {
  std::string text = test::vertex2('A', 3, 13, 0, 0, 0);
  for (const int i : {0, 1, 3, 4}) text += test::motion2('A', i, i + 1, 11 + i, 1, 0, 0);
  for (const int i : {0, 1, 2, 4, 5}) text += test::vertex2('A', i, 10 + i, 0, 0, 0);
  const auto path = only<OdometryPose>(extract(text));
  ASSERT_EQ(path.size(), 6u);
  EXPECT_EQ(log.get("odometry_gaps"), 1);
  EXPECT_NE(said().find("A2 to A3"), std::string::npos) << said();
  EXPECT_EQ(path[3].first, 13 * kSecond);
  EXPECT_DOUBLE_EQ(path[3].second.step_covariance(0, 0), kUnknownPositionVariance);
  EXPECT_DOUBLE_EQ(path[4].second.step_covariance(0, 0), 0.04);
  EXPECT_NEAR(path[5].second.T_O_B.p.x(), 4, 1e-9);
}

TEST_F(Recording, LoopClosuresAreNoOdometry) {
  std::string text = test::twoRobots(5) + test::motion2('A', 0, 3, 103, 7, 7, 0) +
                     test::motion2('A', 4, 1, 104, 7, 7, 0) +
                     "EDGE_SE2 104 A1 B1 0 2 0 1 0 0 1 0 1\n";
  const auto path = only<OdometryPose>(extract(text));
  ASSERT_EQ(path.size(), 5u);
  EXPECT_NEAR(path[4].second.T_O_B.p.x(), 4, 1e-9);
  EXPECT_EQ(log.get("motions_not_odometry"), 3);
  EXPECT_EQ(log.get("odometry_gaps"), 0);
}

TEST_F(Recording, TimeThatDoesNotGrow) {
  std::string text = test::vertex2('A', 0, 10, 0, 0, 0);
  text += test::motion2('A', 0, 1, 11, 1, 0, M_PI / 2) + test::motion2('A', 1, 2, 11, 2, 0, 0) +
          test::motion2('A', 2, 3, 13, 1, 0, 0);
  const auto path = only<OdometryPose>(extract(text));
  ASSERT_EQ(path.size(), 3u);
  EXPECT_EQ(log.get("odometry_time_not_growing"), 1);
  EXPECT_TRUE(path[2].second.T_O_B.p.isApprox(Vec3(1, 3, 0), 1e-8)) << "its motion is not lost";
  // Two steps ahead (0.04 each) along y; across, also 1 m times the first one's heading error.
  const Mat6& c = path[2].second.step_covariance;
  EXPECT_NEAR(c(1, 1), 0.08, 1e-9);
  EXPECT_NEAR(c(0, 0), 0.18 + 0.01, 1e-9);
  EXPECT_NEAR(c(5, 5), 0.02, 1e-12);
  extract(test::vertex2('A', 0, 12, 0, 0, 0) + test::vertex2('A', 1, 11, 1, 0, 0) +
          test::vertex2('A', 2, 12, 2, 0, 0) + test::range(9, "A0", "L0", 1) +
          test::range(8, "A0", "L0", 1));
  EXPECT_EQ(log.get("ground_truth_out_of_order"), 1);
  EXPECT_EQ(log.get("ground_truth_repeated_stamp"), 1);
  EXPECT_EQ(log.get("range_out_of_order"), 1);
}

TEST_F(Recording, WithoutGroundTruthThePathBeginsWithTheFirstMotion) {
  const auto r =
      extract(test::motion2('A', 0, 1, 11, 1, 0, 0) + test::motion2('A', 1, 2, 12, 1, 0, 0));
  const auto path = only<OdometryPose>(r);
  ASSERT_EQ(path.size(), 2u);
  EXPECT_NEAR(path[0].second.T_O_B.p.x(), 1, 1e-9);
  EXPECT_NE(said().find("A0, has no stamp"), std::string::npos) << said();
  EXPECT_TRUE(only<TruePose>(r).empty());
}

TEST_F(Recording, RangesThatMeanNothingHere) {
  const auto r = extract(test::twoRobots(3) + "VERTEX_XY M7 0 0\n" +
                         test::range(101, "A0", "A2", 1) + test::range(101, "A1", "M7", 1));
  EXPECT_EQ(log.get("range_within_robot"), 1);
  EXPECT_EQ(log.get("range_ambiguous_anchor"), 1);
  EXPECT_EQ(only<AnchorRange>(r).size(), 3u);
}

TEST_F(Recording, KindsCanBeLeftOut) {
  options.read_gt = options.read_odometry = options.read_peer_ranges = false;
  EXPECT_EQ(extract(test::twoRobots(4)).events.size(), 4u);
}

TEST(PyfgData, SingleDrone) {
  VIR_REQUIRE_DATA(file, "range_graphs/single_drone.pyfg");
  ProblemLog log;
  const auto r = extractRobot(readGraph(file.string(), &log), {}, &log);
  EXPECT_TRUE(log.counters().empty());
  EXPECT_EQ(r.events.size(), 3 * 1754u);
  ASSERT_EQ(r.landmarks.size(), 1u);
  EXPECT_NEAR(r.landmarks[0].p_W.z(), 0.809476, 1e-6);
}

TEST(PyfgData, TwoGroundRobots) {
  VIR_REQUIRE_DATA(file, "range_graphs/tiers_AB.pyfg");
  for (const std::string robot : {"A", "B"}) {
    ProblemLog log;
    PyfgOptions options;
    options.robot = robot;
    const auto r = extractRobot(readGraph(file.string(), &log), options, &log);
    std::map<std::size_t, int> kinds;
    for (const Event& e : r.events) ++kinds[e.what.index()];
    EXPECT_EQ(kinds[0], robot == "A" ? 2422 : 2440);  // true poses; 20 and 2 repeat a stamp
    EXPECT_EQ(kinds[1], 2442);
    EXPECT_EQ(kinds[2], robot == "A" ? 684 : 551);
    EXPECT_EQ(kinds[3], 764);
    EXPECT_EQ(log.get("odometry_gaps"), 0);
  }
}

}  // namespace
}  // namespace vir::pyfg
