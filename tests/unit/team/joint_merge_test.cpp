#include "vir/team/joint_merge.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vir::team {
namespace {

const Vec3 kAntenna[2] = {Vec3(0.2, 0, 0.1), Vec3(-0.3, 0.4, 0)};
/// From B's world to A's.
const WorldTransform kTruth{0.8, Vec3(3, -1, 0.5)};

/// `level`: each on a floor of its own, which is that of its world.
Pose trueIn(int robot, double s, bool level = false) {
  const double h = robot;
  const Vec3 p(2.5 * std::sin(0.21 * s + h) + 2 * h, 2 * std::sin(0.33 * s + 2 * h),
               level ? h * kTruth.t_m.z() : 0.5 * std::sin(0.17 * s + h));
  return {Quat(rotZ(0.3 * std::sin(0.1 * s) + h)), p};
}

/// A's world is the true one, B's is `kTruth` away from it; both estimates are exact.
std::vector<RobotRecord> robots(bool level = false) {
  std::vector<RobotRecord> out(2);
  out[0].name = "A";
  out[1].name = "B";
  out[1].id = 1;
  for (int robot = 0; robot < 2; ++robot) {
    RobotRecord& r = out[static_cast<std::size_t>(robot)];
    const Pose T_own_W = robot == 0 ? Pose() : kTruth.inverse().pose();
    for (int k = 0; k <= 600; ++k) {
      const double s = 0.1 * k;
      const TimeNs t = fromSeconds(s);
      const Pose T = T_own_W * trueIn(robot, s, level);
      r.odometry.push_back({t, T});
      KnownPose known;
      known.t = t;
      known.T_W_B = T;
      r.poses.push_back(known);
    }
  }
  for (int k = 3; k < 600; k += 2) {
    const double s = 0.1 * k;
    const double d = (trueIn(0, s, level) * kAntenna[0] - trueIn(1, s, level) * kAntenna[1]).norm();
    out[0].peer_ranges.push_back({fromSeconds(s), 1, d, 0.05, kAntenna[0]});
  }
  // B has never asked anybody but an anchor.
  out[1].anchor_ranges.push_back({fromSeconds(1), 4, -1, 0.05, kAntenna[1]});
  return out;
}

struct Merge {
  std::vector<RobotRecord> records = robots();
  std::vector<PairResult> pairs;
  MergedMap map;
  JointSolution solution;
  JointOptions options;

  /// As found from the ranges alone: roughly.
  void prepare() {
    PairResult pair;
    pair.transform.from = "B";
    pair.transform.to = "A";
    pair.transform.answer.status = TransformStatus::unique;
    TransformSolution s;
    s.T_A_B = {kTruth.yaw_rad + 0.05, kTruth.t_m + Vec3(0.2, -0.1, 0.05)};
    pair.transform.answer.solutions.push_back(s);
    pair.ranges = mutualRanges(records[0], records[1]);
    pairs = {pair};
    map = merge(records, edgesOf(pairs));
  }
  std::string run() { return mergeJointly(records, options, &map, &pairs, &solution); }
};

TEST(JointMerge, FindsTheTransformAndLaysThePathsIntoOneWorld) {
  Merge m;
  m.prepare();
  ASSERT_EQ(m.map.root, "A");
  ASSERT_EQ(m.run(), "");
  const PairTransform& t = m.pairs[0].transform;
  EXPECT_TRUE(t.joint);
  const TransformSolution& s = t.answer.solutions[0];
  // Exact but for both antennas, which are half a metre from the bodies' origins.
  EXPECT_NEAR(s.T_A_B.yaw_rad, kTruth.yaw_rad, 2e-3);
  EXPECT_LT((s.T_A_B.t_m - kTruth.t_m).norm(), 1e-2) << s.T_A_B.t_m.transpose();
  EXPECT_LT((m.map.T_root.at("B").t_m - kTruth.t_m).norm(), 1e-2);
  EXPECT_LT(s.covariance(1, 1), 0.1) << "no longer what it was";
  const Trajectory& b = m.map.trajectories.at("B");
  ASSERT_EQ(b.size(), 601u);
  for (const StampedPose& p : b) {
    ASSERT_LT((p.T_W_B.p - trueIn(1, toSeconds(p.t)).p).norm(), 2e-2);
  }
}

/// Nobody knows where B's antenna is: worse, and the ranges count less, but no nonsense.
TEST(JointMerge, AnUnknownAntennaIsBorneByTheRanges) {
  Merge known, unknown;
  known.prepare();
  unknown.records[1].anchor_ranges.clear();
  // Nor would the ranges say more than that of where bodies turn.
  known.options.centre_sigma_m = unknown.options.centre_sigma_m = 0;
  unknown.prepare();
  EXPECT_EQ(unknown.pairs[0].ranges.antenna_unknown,
            static_cast<long>(unknown.pairs[0].ranges.list.size()));
  ASSERT_EQ(known.run(), "");
  ASSERT_EQ(unknown.run(), "");
  const auto variance = [](const Merge& m) {
    return m.pairs[0].transform.answer.solutions[0].covariance(1, 1);
  };
  EXPECT_GT(variance(unknown), 1.5 * variance(known));
  EXPECT_LT((unknown.map.T_root.at("B").t_m - kTruth.t_m).norm(), 0.6);
}

/// The mean of two heights explains no range: paths were bent to suit it.
TEST(JointMerge, OfOpenHeightsTheOneThatExplainsTheRangesIsSolvedWith) {
  Merge m;
  m.records = robots(true);
  m.prepare();
  TransformSolution& before = m.pairs[0].transform.answer.solutions[0];
  before.T_A_B.t_m.z() = 0.1;
  before.covariance = Eigen::Vector4d(0.01, 0.04, 0.04, 0.36).asDiagonal();
  m.map = merge(m.records, edgesOf(m.pairs));
  ASSERT_EQ(m.run(), "");
  const TransformSolution& s = m.pairs[0].transform.answer.solutions[0];
  EXPECT_NEAR(s.T_A_B.yaw_rad, kTruth.yaw_rad, 1e-2);
  EXPECT_LT((s.T_A_B.t_m - kTruth.t_m).head<2>().norm(), 0.02) << s.T_A_B.t_m.transpose();
  EXPECT_EQ(s.T_A_B.t_m.z(), 0.1) << "what is known of the height is what it was";
  EXPECT_GE(s.covariance(3, 3), 0.36);
  EXPECT_NEAR(m.map.T_root.at("B").t_m.z(), 0.1, 1e-6);
  for (const StampedPose& p : m.map.trajectories.at("B")) {
    ASSERT_LT((p.T_W_B.p - trueIn(1, toSeconds(p.t), true).p).head<2>().norm(), 0.03);
    ASSERT_NEAR(p.T_W_B.p.z(), 0.1, 0.02);
  }
}

TEST(JointMerge, LeavesAllAsItIsWhereItCannot) {
  Merge camera;
  camera.records[1].sees = true;
  camera.prepare();
  const WorldTransform before = camera.map.T_root.at("B");
  EXPECT_NE(camera.run().find("robot B was not estimated from odometry"), std::string::npos);
  EXPECT_EQ(camera.map.T_root.at("B").t_m, before.t_m);
  EXPECT_FALSE(camera.pairs[0].transform.joint);

  Merge restarted;
  for (std::size_t k = 300; k < 601; ++k) restarted.records[1].poses[k].segment = 1;
  restarted.prepare();
  EXPECT_NE(restarted.run().find("robot B started a new world"), std::string::npos);

  Merge alone;
  alone.prepare();
  alone.map.T_root.erase("B");
  EXPECT_NE(alone.run().find("two robots with poses that are tied together"), std::string::npos);
}

TEST(MergedMap, InTheWorldThatMostAreTiedTo) {
  std::vector<RobotRecord> three = robots();
  three.push_back(three[1]);
  three[2].name = "C";
  three[2].id = 2;
  PairResult bc;
  bc.transform.from = "C";
  bc.transform.to = "B";
  bc.transform.answer.status = TransformStatus::unique;
  TransformSolution s;
  s.T_A_B = {0.1, Vec3(1, 0, 0)};
  bc.transform.answer.solutions.push_back(s);
  PairResult open = bc;
  open.transform.to = "A";
  open.transform.answer.status = TransformStatus::ambiguous;
  const auto edges = edgesOf({bc, open});
  ASSERT_EQ(edges.size(), 1u);
  const MergedMap map = merge(three, edges);
  EXPECT_EQ(map.root, "B") << "the first of two equals; A is tied to nobody";
  EXPECT_EQ(map.T_root.count("A"), 0u);
  EXPECT_EQ(map.T_root.at("C").t_m, Vec3(1, 0, 0));
  EXPECT_EQ(map.trajectories.count("A"), 0u);
  EXPECT_EQ(map.trajectories.at("C").size(), three[2].poses.size());
}

}  // namespace
}  // namespace vir::team
