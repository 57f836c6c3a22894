#include "vir/team/robot_record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace vir::team {
namespace {

constexpr TimeNs kMs = 1000000;

KnownPose pose(TimeNs t, double x, int segment = 0) {
  KnownPose p;
  p.t = t;
  p.T_W_B.p.x() = x;
  p.covariance(0, 0) = x;
  p.segment = segment;
  return p;
}

TEST(KnownPoses, InterpolatedBetweenNeighbours) {
  const std::vector<KnownPose> poses{pose(0, 0), pose(100 * kMs, 1), pose(200 * kMs, 3)};
  const auto between = poseAt(poses, 150 * kMs);
  ASSERT_TRUE(between);
  EXPECT_EQ(between->t, 150 * kMs);
  EXPECT_DOUBLE_EQ(between->T_W_B.p.x(), 2);
  EXPECT_EQ(between->covariance(0, 0), 1) << "of the pose before";
  EXPECT_EQ(poseAt(poses, 100 * kMs)->T_W_B.p.x(), 1);
  EXPECT_FALSE(poseAt(poses, -1));
  EXPECT_FALSE(poseAt(poses, 200 * kMs + 1));
  EXPECT_FALSE(poseAt({}, 0));
}

TEST(KnownPoses, NeitherAcrossAGapNorIntoAnotherWorld) {
  const std::vector<KnownPose> gap{pose(0, 0), pose(501 * kMs, 1)};
  EXPECT_FALSE(poseAt(gap, 250 * kMs));
  EXPECT_TRUE(poseAt(gap, 501 * kMs));
  EXPECT_TRUE(poseAt({pose(0, 0), pose(500 * kMs, 1)}, 250 * kMs));
  const std::vector<KnownPose> restarted{pose(0, 0, 0), pose(100 * kMs, 1, 1),
                                         pose(200 * kMs, 2, 1)};
  EXPECT_FALSE(poseAt(restarted, 50 * kMs));
  EXPECT_EQ(poseAt(restarted, 100 * kMs)->segment, 1);
  EXPECT_EQ(poseAt(restarted, 150 * kMs)->segment, 1);
}

TEST(KnownPoses, OnlyGoodOnesAreKept) {
  std::vector<KnownPose> poses;
  StateEstimate e;
  e.valid = true;
  e.state.t = 100 * kMs;
  e.segment = 2;
  EXPECT_TRUE(keepPose(e, &poses));
  EXPECT_EQ(poses.back().segment, 2);
  EXPECT_FALSE(keepPose(e, &poses)) << "its time is there already";
  e.state.t = 50 * kMs;
  EXPECT_FALSE(keepPose(e, &poses)) << "out of order";
  e.state.t = 200 * kMs;
  e.valid = false;
  EXPECT_FALSE(keepPose(e, &poses));
  e.valid = true;
  e.state.T_W_B.p.x() = std::nan("");
  EXPECT_FALSE(keepPose(e, &poses));
  e.state.T_W_B.p.x() = 0;
  e.state.T_W_B.q.w() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(keepPose(e, &poses));
  EXPECT_EQ(poses.size(), 1u);
}

Anchor anchor(AnchorState state) {
  Anchor a;
  a.id = 4;
  a.state = state;
  a.has_position = true;
  a.p_W = Vec3(1, 2, 3);
  a.covariance = 0.04 * Mat3::Identity();
  return a;
}

TEST(Believed, OnlyWhatTheStateAllows) {
  for (const AnchorState state : {AnchorState::estimated, AnchorState::fixed}) {
    const auto b = believed(anchor(state));
    ASSERT_TRUE(b) << name(state);
    EXPECT_EQ(b->p_W, Vec3(1, 2, 3));
    EXPECT_EQ(b->covariance, anchor(state).covariance);
  }
  EXPECT_FALSE(believed(anchor(AnchorState::collecting)));
  EXPECT_FALSE(believed(anchor(AnchorState::moved)));
}

TEST(Believed, TwoMirrorImagesOnlyWhereTheyAreClose) {
  Anchor a = anchor(AnchorState::mirror_open);
  a.mirror_p_W = a.p_W + Vec3(0.9, 0, 0);
  const auto near = believed(a);
  ASSERT_TRUE(near);
  EXPECT_EQ(near->covariance, a.covariance) << "it spans both positions already";
  a.mirror_p_W = a.p_W + Vec3(1.1, 0, 0);
  EXPECT_FALSE(believed(a));
  a.mirror_p_W.x() = std::nan("");
  EXPECT_FALSE(believed(a));
}

TEST(Believed, TwoMirrorImagesOneAboveTheOtherAreTheirMiddle) {
  Anchor a = anchor(AnchorState::mirror_open);
  a.mirror_p_W = a.p_W + Vec3(0.2, -0.1, -4);
  const auto between = believed(a);
  ASSERT_TRUE(between);
  EXPECT_LT((between->p_W - (a.p_W + Vec3(0.1, -0.05, -2))).norm(), 1e-12);
  EXPECT_EQ(between->covariance, a.covariance) << "it spans both positions already";
}

TEST(Believed, NothingWithoutFiniteNumbers) {
  Anchor a = anchor(AnchorState::fixed);
  a.has_position = false;
  EXPECT_FALSE(believed(a));
  a = anchor(AnchorState::fixed);
  a.p_W.y() = std::nan("");
  EXPECT_FALSE(believed(a));
  a = anchor(AnchorState::fixed);
  a.covariance(1, 2) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(believed(a));
}

TEST(RobotRecord, AnchorsAsTheyWereBelievedThen) {
  RobotRecord record;
  EXPECT_FALSE(record.snapshotDue()) << "no pose yet";
  EXPECT_TRUE(record.anchorsAt(0).empty());
  record.poses.push_back(pose(100 * kMs, 0));
  EXPECT_TRUE(record.snapshotDue());
  record.takeSnapshot({});
  record.poses.push_back(pose(250 * kMs, 0));
  EXPECT_FALSE(record.snapshotDue()) << "one every 0.2 s";
  record.poses.push_back(pose(300 * kMs, 0));
  ASSERT_TRUE(record.snapshotDue());
  record.takeSnapshot({anchor(AnchorState::fixed)});
  EXPECT_TRUE(record.anchorsAt(99 * kMs).empty());
  EXPECT_TRUE(record.anchorsAt(299 * kMs).empty());
  EXPECT_EQ(record.anchorsAt(300 * kMs).size(), 1u);
  EXPECT_EQ(record.anchorsAt(9000 * kMs).size(), 1u);
}

TEST(RobotRecord, TheAntennaIsWhereItsOwnRangesSay) {
  RobotRecord record;
  EXPECT_FALSE(record.antenna());
  Range r;
  r.p_B_U = Vec3(0.1, 0, 0.2);
  record.anchor_ranges.push_back(r);
  EXPECT_EQ(*record.antenna(), r.p_B_U);
  r.p_B_U = Vec3(0.3, 0, 0.2);
  record.peer_ranges.push_back(r);
  EXPECT_EQ(*record.antenna(), r.p_B_U);
}

TEST(RobotRecord, IdsOfRobotsAreSigned) {
  Range r;
  r.anchor = 5;
  EXPECT_EQ(robotOf(r), 5);
  r.anchor = 4294967294;
  EXPECT_EQ(robotOf(r), -2);
}

}  // namespace
}  // namespace vir::team
