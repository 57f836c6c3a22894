#include "vir/team/peer_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>

#include "fake_solver.h"

namespace vir::team {
namespace {

constexpr TimeNs kMs = 1000000;
constexpr TimeNs kStart = 1000000 * kMs;

class PeerTracking : public testing::Test {
 protected:
  /// All stamps are in milliseconds from the start.
  void pose(int ms, double x = 0, int segment = 0) {
    StateEstimate e;
    e.valid = true;
    e.state.t = kStart + ms * kMs;
    e.state.T_W_B.p.x() = x;
    e.segment = segment;
    tracker_.addState(e);
  }
  void range(int ms, std::uint64_t peer = 5) {
    Range r;
    r.t = kStart + ms * kMs;
    r.anchor = peer;
    r.range_m = 4;
    r.sigma_m = 0.05;
    r.p_B_U = Vec3(0, 0, 0.2);
    now(ms);
    tracker_.addRange(r);
  }
  void told(int ms, const Vec3& p, double sigma_m = 0.1, int peer = 5) {
    now(ms);
    tracker_.hear({peer, {}, {kStart + ms * kMs, p, sigma_m * sigma_m * Mat3::Identity()}});
  }
  void toldAnchor(int ms, std::uint64_t anchor, const Vec3& p) {
    now(ms);
    tracker_.hear({5, anchor, {kStart + ms * kMs, p, 0.01 * Mat3::Identity()}});
  }
  void now(int ms) { tracker_.advance(kStart + ms * kMs); }
  void use() {
    tracker_.use([this] { return anchors_; });
  }
  void finish() {
    tracker_.finish([this] { return anchors_; });
  }
  const std::vector<test::Given>& given() const { return solvers_.front().given; }
  PeerResult peer() const { return tracker_.peers().at(0); }

  std::vector<Anchor> anchors_;
  std::deque<test::SolverNotes> solvers_;
  std::vector<std::string> lines_;
  PeerTracker tracker_{PeerTrackerOptions{},
                       test::fakeSolvers(&solvers_, TransformStatus::degenerate),
                       [this](LogLevel, const std::string& text) { lines_.push_back(text); }};
};

TEST_F(PeerTracking, ARangeWaitsForThePoseBehindIt) {
  pose(0, 0);
  range(10);
  told(10, Vec3(7, 8, 9));
  use();
  EXPECT_TRUE(given().empty());
  pose(20, 1);
  use();
  ASSERT_EQ(given().size(), 1u);
  const MutualRange& r = given()[0].range;
  EXPECT_LT((r.p_A - Vec3(0.5, 0, 0.2)).norm(), 1e-12) << "its antenna, between the two poses";
  EXPECT_EQ(r.p_B, Vec3(7, 8, 9));
  EXPECT_EQ(r.range_m, 4);
  EXPECT_NEAR(r.cov_B(1, 1), 0.01, 1e-15);
  EXPECT_EQ(peer().ranges, 1);
  EXPECT_EQ(peer().without_broadcast + peer().without_pose, 0);
}

TEST_F(PeerTracking, ARangeWaitsForItsBroadcast) {
  pose(0);
  range(10);
  pose(20);
  use();
  EXPECT_TRUE(given().empty());
  now(150);
  told(12, Vec3(7, 8, 9));  // within 2 ms of its range
  use();
  EXPECT_EQ(given().size(), 1u);
}

TEST_F(PeerTracking, CountsARangeWhoseBroadcastIsMissing) {
  pose(0);
  range(10);
  pose(20);
  now(209);
  use();
  EXPECT_EQ(peer().without_broadcast, 0) << "it may still come";
  now(210);
  use();
  EXPECT_EQ(peer().without_broadcast, 1);
  told(10, Vec3(7, 8, 9));
  use();
  EXPECT_TRUE(given().empty()) << "too late";
  // That of another time is not its own.
  range(300);
  told(303, Vec3(7, 8, 9));
  pose(320);
  now(600);
  use();
  EXPECT_EQ(peer().without_broadcast, 2);
}

TEST_F(PeerTracking, CountsARangeWithoutAPose) {
  range(10);
  told(10, Vec3(7, 8, 9));
  now(2009);
  use();
  EXPECT_EQ(peer().without_pose, 0) << "a pose may still come";
  now(2010);
  use();
  EXPECT_EQ(peer().without_pose, 1);
  // Nor across a gap, nor where the own world began anew.
  pose(3000);
  range(3300);
  told(3300, Vec3(7, 8, 9));
  pose(3600);
  range(3650);
  told(3650, Vec3(7, 8, 9));
  pose(3700, 0, 1);
  use();
  EXPECT_EQ(peer().without_pose, 3);
  EXPECT_TRUE(given().empty());
}

TEST_F(PeerTracking, ANewWorldOfTheOtherRobot) {
  anchors_.resize(1);
  anchors_[0].id = 4;
  anchors_[0].has_position = true;
  anchors_[0].state = AnchorState::estimated;
  toldAnchor(0, 4, Vec3(1, 1, 1));
  for (int k = 0; k < 4; ++k) {
    const int ms = 1000 * k;
    pose(ms, 0, k == 3 ? 1 : 0);
    range(ms);
    told(ms, Vec3(k < 2 ? 20 * k : 200, 0, 0));
    use();
    EXPECT_EQ(solvers_[0].anchors.size(), k < 2 ? 1u : 0u) << "they were in the old world";
  }
  ASSERT_EQ(given().size(), 4u);
  EXPECT_EQ(given()[1].segment_B, 0) << "20 m in a second is fast, not another world";
  EXPECT_EQ(given()[2].segment_B, 1);
  EXPECT_EQ(given()[3].segment_B, 1);
  EXPECT_EQ(given()[2].segment_A, 0);
  EXPECT_EQ(given()[3].segment_A, 1) << "the own one";
}

TEST_F(PeerTracking, AJumpWithinItsUncertaintyIsNone) {
  for (int k = 0; k < 2; ++k) {
    pose(100 * k);
    range(100 * k);
    told(100 * k, Vec3(50.0 * k, 0, 0), 10);  // four sigmas in three dimensions: 69 m
  }
  use();
  ASSERT_EQ(given().size(), 2u);
  EXPECT_EQ(given()[1].segment_B, 0);
}

TEST_F(PeerTracking, FollowsThirtyTwoRobotsAndCountsTheRest) {
  for (std::uint64_t id = 0; id < 40; ++id) range(10, id);
  EXPECT_EQ(tracker_.peers().size(), 32u);
  EXPECT_EQ(tracker_.rangesOfTooManyRobots(), 8);
  EXPECT_EQ(solvers_.size(), 32u);
}

TEST_F(PeerTracking, KeepsSoManyAnchorsOfARobotAndCountsTheRest) {
  for (std::uint64_t id = 0; id < 256; ++id) toldAnchor(10, id, Vec3(1, 2, 3));
  EXPECT_EQ(tracker_.unusableBroadcasts(), 0);
  toldAnchor(10, 256, Vec3(1, 2, 3));
  toldAnchor(20, 0, Vec3(4, 5, 6));  // known: may be told again
  EXPECT_EQ(tracker_.unusableBroadcasts(), 1);
}

TEST_F(PeerTracking, CountsBroadcastsThatAreNoNumbers) {
  told(10, Vec3(1, std::nan(""), 3));
  told(20, Vec3(1, 2, 3), std::numeric_limits<double>::infinity());
  tracker_.countUnusableBroadcast();
  EXPECT_EQ(tracker_.unusableBroadcasts(), 3);
  EXPECT_FALSE(tracker_.met());
}

TEST_F(PeerTracking, WhoIsOnlyOverheardIsNoPeer) {
  told(10, Vec3(1, 2, 3));
  finish();
  EXPECT_TRUE(tracker_.met());
  EXPECT_TRUE(tracker_.peers().empty());
  EXPECT_TRUE(tracker_.pairs().empty());
}

TEST_F(PeerTracking, AsksEveryHalfSecondAndInTheEnd) {
  for (int k = 0; k <= 8; ++k) {
    const int ms = 100 * k;
    pose(ms);
    range(ms);
    told(ms, Vec3(7, 8, 9));
    if (k == 5) solvers_[0].status = TransformStatus::unique;
    use();
  }
  EXPECT_EQ(solvers_[0].asked, 2);  // at 0 and 0.5 s
  EXPECT_DOUBLE_EQ(*peer().transform.first_unique_s, 0.5);
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_NE(lines_[0].find("robot 5 is placed after 0.5 s"), std::string::npos) << lines_[0];
  solvers_[0].status = TransformStatus::ambiguous;
  finish();
  EXPECT_EQ(solvers_[0].asked, 3);
  ASSERT_EQ(lines_.size(), 2u);
  EXPECT_NE(lines_[1].find("became open again: the test says so"), std::string::npos);
  EXPECT_EQ(tracker_.pairs().at(0).history.size(), 3u);
  EXPECT_EQ(peer().transform.from, "5");
  EXPECT_EQ(peer().transform.to, kThisRobot);
  // What the solver says is told with the robot's number.
  solvers_[0].log(LogLevel::warning, "hm");
  EXPECT_EQ(lines_.back(), "robot 5: hm");
}

TEST_F(PeerTracking, AnchorsThatBothKnow) {
  for (const std::uint64_t id : {4, 5, 6}) {
    Anchor a;
    a.id = id;
    a.has_position = true;
    a.p_W = Vec3(static_cast<double>(id), 0, 0);
    a.state = id == 5 ? AnchorState::moved : AnchorState::estimated;
    anchors_.push_back(a);
  }
  toldAnchor(0, 4, Vec3(1, 1, 1));
  toldAnchor(0, 5, Vec3(2, 2, 2));
  toldAnchor(0, 9, Vec3(3, 3, 3));
  pose(0);
  range(0);
  told(0, Vec3(7, 8, 9));
  use();
  ASSERT_EQ(solvers_[0].anchors.size(), 1u);
  EXPECT_EQ(solvers_[0].anchors[0].id, 4u);
  EXPECT_EQ(solvers_[0].anchors[0].p_A, Vec3(4, 0, 0));
  EXPECT_EQ(solvers_[0].anchors[0].p_B, Vec3(1, 1, 1));
}

TEST_F(PeerTracking, TheEndUsesOrCountsWhatStillWaits) {
  pose(0);
  range(0);
  told(0, Vec3(7, 8, 9));
  range(10);
  told(10, Vec3(7, 8, 9));
  range(20);
  finish();
  EXPECT_EQ(given().size(), 1u);
  EXPECT_EQ(peer().without_pose, 1);
  EXPECT_EQ(peer().without_broadcast, 1);
  EXPECT_EQ(peer().ranges, 3);
}

TEST_F(PeerTracking, APositionBeyondTheEarthIsNotHeard) {
  for (int ms = 0; ms <= 1000; ms += 100) pose(ms);
  for (const double far : {1e9, 1e308, -1e308}) {
    range(500);
    told(500, Vec3(far, 0, 0));
  }
  finish();
  EXPECT_EQ(peer().without_broadcast, 3);
  EXPECT_EQ(tracker_.unusableBroadcasts(), 3);
}

}  // namespace
}  // namespace vir::team
