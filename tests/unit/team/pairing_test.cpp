#include "vir/team/pairing.h"

#include <gtest/gtest.h>

#include "fake_solver.h"

namespace vir::team {
namespace {

constexpr TimeNs kMs = 1000000;

/// Standing at x for two seconds, a pose every 100 ms, turned to the left by a quarter.
RobotRecord robot(const std::string& name, int id, double x) {
  RobotRecord out;
  out.name = name;
  out.id = id;
  for (int k = 0; k <= 20; ++k) {
    KnownPose p;
    p.t = 100 * k * kMs;
    p.T_W_B = Pose(expQuat(Vec3(0, 0, M_PI / 2)), Vec3(x, 0, 0));
    p.covariance.topLeftCorner<3, 3>() = 0.01 * Mat3::Identity();
    out.poses.push_back(p);
  }
  return out;
}

Range rangeTo(int peer, TimeNs t, double range_m, const Vec3& p_B_U = Vec3::Zero()) {
  return {t, static_cast<std::uint32_t>(peer), range_m, 0.05, p_B_U};
}

TEST(MutualRanges, BothAntennasAreWhereTheRecordingsSay) {
  RobotRecord a = robot("A", 0, 0), b = robot("B", 1, 5);
  a.peer_ranges = {rangeTo(1, 250 * kMs, 4.9, Vec3(0.2, 0, 0.1))};
  b.peer_ranges = {rangeTo(0, 1500 * kMs, 5.1, Vec3(0, 0.3, 0))};
  const MutualRanges m = mutualRanges(a, b);
  ASSERT_EQ(m.list.size(), 2u);
  // Turned by a quarter: what is ahead of the body is at +y of the world.
  for (const MutualObservation& o : m.list) {
    EXPECT_LT((o.range.p_A - Vec3(0, 0.2, 0.1)).norm(), 1e-12) << o.range.p_A.transpose();
    EXPECT_LT((o.range.p_B - Vec3(5 - 0.3, 0, 0)).norm(), 1e-12) << o.range.p_B.transpose();
    EXPECT_EQ(o.antenna_A, Vec3(0.2, 0, 0.1));
    EXPECT_EQ(o.antenna_B, Vec3(0, 0.3, 0));
    EXPECT_FALSE(o.antenna_unknown);
    EXPECT_LT((o.range.cov_B - 0.01 * Mat3::Identity()).norm(), 1e-15);
  }
  EXPECT_EQ(m.antenna_unknown, 0);
}

/// A robot that only answers has its antenna where its ranges to anchors say.
TEST(MutualRanges, ARobotThatOnlyAnswers) {
  RobotRecord a = robot("A", 0, 0), b = robot("B", 1, 5);
  a.peer_ranges = {rangeTo(1, 250 * kMs, 4.9)};
  b.anchor_ranges = {rangeTo(44, 0, 2, Vec3(0.4, 0, 0))};
  const MutualRanges known = mutualRanges(a, b);
  ASSERT_EQ(known.list.size(), 1u);
  EXPECT_LT((known.list[0].range.p_B - Vec3(5, 0.4, 0)).norm(), 1e-12);
  EXPECT_EQ(known.antenna_unknown, 0);
  // It may also be the second one that asks.
  EXPECT_LT((mutualRanges(b, a).list[0].range.p_A - Vec3(5, 0.4, 0)).norm(), 1e-12);
}

/// Without a word of where it is: never silently in the origin.
TEST(MutualRanges, AnUnknownAntennaWidensTheCovarianceAndIsCounted) {
  RobotRecord a = robot("A", 0, 0), b = robot("B", 1, 5);
  a.peer_ranges = {rangeTo(1, 250 * kMs, 4.9), rangeTo(1, 350 * kMs, 4.9)};
  const MutualRanges m = mutualRanges(a, b);
  ASSERT_EQ(m.list.size(), 2u);
  EXPECT_EQ(m.antenna_unknown, 2);
  EXPECT_TRUE(m.list[0].antenna_unknown);
  EXPECT_LT((m.list[0].range.p_B - Vec3(5, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(m.list[0].range.cov_B(0, 0), 0.01 + kUnknownAntennaSigma * kUnknownAntennaSigma,
              1e-15);
  EXPECT_NEAR(m.list[0].range.cov_A(0, 0), 0.01, 1e-15) << "that of the one that asked is known";
}

TEST(MutualRanges, InOrderOfTimeAndEachOnce) {
  RobotRecord a = robot("A", 0, 0), b = robot("B", 1, 5);
  a.peer_ranges = {rangeTo(1, 300 * kMs, 5), rangeTo(1, 900 * kMs, 5.2), rangeTo(7, 950 * kMs, 1)};
  b.peer_ranges = {rangeTo(0, 100 * kMs, 5.1), rangeTo(0, 901 * kMs, 5.2),
                   rangeTo(0, 1000 * kMs, 5.2)};
  const MutualRanges m = mutualRanges(a, b);
  ASSERT_EQ(m.list.size(), 4u);
  EXPECT_EQ(m.doubled, 1) << "900 and 901 ms are one range in two recordings";
  EXPECT_EQ(m.list[0].range.t, 100 * kMs);
  EXPECT_EQ(m.list[3].range.t, 1000 * kMs);
  EXPECT_NEAR(m.list[0].range.p_A.x(), 0, 1e-12) << "A is the one named first, whoever asked";
}

TEST(MutualRanges, WithoutAPoseCountedWithSegmentsKept) {
  RobotRecord a = robot("A", 0, 0), b = robot("B", 1, 5);
  for (std::size_t k = 10; k <= 20; ++k) b.poses[k].segment = 3;
  a.peer_ranges = {rangeTo(1, 850 * kMs, 5), rangeTo(1, 950 * kMs, 5), rangeTo(1, 1050 * kMs, 5),
                   rangeTo(1, 5000 * kMs, 5)};
  const MutualRanges m = mutualRanges(a, b);
  ASSERT_EQ(m.list.size(), 2u);
  EXPECT_EQ(m.without_state, 2) << "where B began anew, and behind the end";
  EXPECT_EQ(m.list[0].segment_B, 0);
  EXPECT_EQ(m.list[1].segment_B, 3);
  EXPECT_EQ(m.list[1].segment_A, 0);
}

Anchor anchor(std::uint64_t id, const Vec3& p, AnchorState state) {
  Anchor a;
  a.id = id;
  a.has_position = true;
  a.p_W = p;
  a.covariance = 0.02 * Mat3::Identity();
  a.state = state;
  return a;
}

TEST(SharedAnchors, ThoseThatBothBelievedInThen) {
  RobotRecord a = robot("A", 0, 0), b = robot("B", 1, 5);
  a.anchors.push_back({0,
                       {anchor(4, Vec3(1, 0, 0), AnchorState::estimated),
                        anchor(5, Vec3(2, 0, 0), AnchorState::moved),
                        anchor(6, Vec3(3, 0, 0), AnchorState::fixed)}});
  b.anchors.push_back({500 * kMs,
                       {anchor(4, Vec3(-1, 0, 0), AnchorState::fixed),
                        anchor(5, Vec3(-2, 0, 0), AnchorState::fixed)}});
  EXPECT_TRUE(sharedAnchors(a, b, 400 * kMs).empty());
  const auto shared = sharedAnchors(a, b, 500 * kMs);
  ASSERT_EQ(shared.size(), 1u);
  EXPECT_EQ(shared[0].id, 4u);
  EXPECT_EQ(shared[0].p_A, Vec3(1, 0, 0));
  EXPECT_EQ(shared[0].p_B, Vec3(-1, 0, 0));
}

TEST(PlayPair, AsksEveryIntervalAndInTheEnd) {
  RobotRecord a = robot("A", 0, 0), b = robot("B", 1, 5);
  for (int k = 0; k < 10; ++k) a.peer_ranges.push_back(rangeTo(1, (200 + 100 * k) * kMs, 5));
  a.anchors.push_back({0, {anchor(4, Vec3(1, 0, 0), AnchorState::estimated)}});
  b.anchors.push_back({0, {anchor(4, Vec3(2, 0, 0), AnchorState::estimated)}});
  test::SolverNotes notes;
  notes.status = TransformStatus::unique;
  test::FakeSolver solver(&notes);
  const PairResult pair = playPair(a, b, &solver, {0.4, true});
  EXPECT_EQ(pair.transform.from, "B");
  EXPECT_EQ(pair.transform.to, "A");
  EXPECT_EQ(notes.given.size(), 10u);
  EXPECT_EQ(notes.anchors.size(), 1u);
  // At 0, 0.4, 0.8 s and at the last one, 0.9 s.
  ASSERT_EQ(pair.history.size(), 4u);
  EXPECT_NEAR(pair.history[1].since_first_s, 0.4, 1e-9);
  EXPECT_NEAR(pair.history[3].since_first_s, 0.9, 1e-9);
  ASSERT_TRUE(pair.transform.first_unique_s);
  EXPECT_EQ(*pair.transform.first_unique_s, 0);
}

TEST(PlayPair, WithoutARangeItSaysWhatTheSolverSays) {
  test::SolverNotes notes;
  test::FakeSolver solver(&notes);
  const PairResult pair = playPair(robot("A", 0, 0), robot("B", 1, 5), &solver, {0.5, true});
  EXPECT_TRUE(pair.history.empty());
  EXPECT_EQ(pair.transform.answer.status, TransformStatus::degenerate);
  EXPECT_EQ(pair.transform.answer.reason, "the test says so");
}

}  // namespace
}  // namespace vir::team
