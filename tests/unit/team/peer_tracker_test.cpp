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
  void path(int ms, const Vec3& p, int world = 0, int peer = 5) {
    PeerPose pose;
    pose.peer = peer;
    pose.world = world;
    pose.t = kStart + ms * kMs;
    pose.T_W_B.p = p;
    pose.covariance = 0.01 * Mat3::Identity();
    pose.p_B_U = Vec3(0, 0, 0.5);
    tracker_.hear(pose);
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

TEST_F(PeerTracking, PosesOfAFrameThatHasEndedAreSeenInTheNewOne) {
  pose(0, 0);
  pose(20, 1);
  range(15);
  told(15, Vec3(7, 8, 9));
  const WorldTransform T{M_PI / 2, Vec3(10, 20, 1)};
  tracker_.changeFrame({kStart + 1000 * kMs, T.pose()});
  use();
  EXPECT_LT((given().at(0).range.p_A - T * Vec3(0.75, 0, 0.2)).norm(), 1e-12);
  ASSERT_EQ(solvers_.front().moved.size(), 1u);
  EXPECT_NEAR(solvers_.front().moved[0].yaw_rad, M_PI / 2, 1e-12);
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
  int ms = 500;
  for (const double far : {1e9, 1e308, -1e308}) {
    range(ms);
    told(ms, Vec3(far, 0, 0));
    ms += 10;
  }
  finish();
  EXPECT_EQ(peer().without_broadcast, 3);
  EXPECT_EQ(tracker_.unusableBroadcasts(), 3);
}

TEST_F(PeerTracking, BetweenTwoPosesOfTheOtherRobot) {
  pose(0);
  range(100);
  pose(200);
  path(0, Vec3(10, 0, 0));
  use();
  EXPECT_TRUE(given().empty()) << "it waits for the pose behind the range";
  path(400, Vec3(18, 0, 0));
  path(200, Vec3(12, 0, 0));  // later than the one behind it
  path(200, Vec3(99, 0, 0));  // twice
  use();
  ASSERT_EQ(given().size(), 1u);
  const MutualRange& r = given()[0].range;
  EXPECT_LT((r.p_B - Vec3(11, 0, 0.5)).norm(), 1e-12) << "its antenna";
  EXPECT_NEAR(r.cov_B(0, 0), 0.01 + std::pow(0.5 * 0.1 * 0.1, 2), 1e-12);
  ASSERT_TRUE(peer().told);
  EXPECT_EQ(peer().told->T_W_B.p, Vec3(18, 0, 0));
}

TEST_F(PeerTracking, APathWithAHoleSaysNothingInIt) {
  pose(0);
  pose(400);
  pose(800);
  path(0, Vec3(1, 0, 0));
  range(300);
  path(600, Vec3(1, 0, 0));  // more than half a second
  now(2299);
  use();
  EXPECT_EQ(peer().without_broadcast, 0);
  now(2300);
  use();
  EXPECT_EQ(peer().without_broadcast, 1);
  EXPECT_TRUE(given().empty());
}

TEST_F(PeerTracking, ARestartedRobotsPathIsInAnotherWorld) {
  anchors_.resize(1);
  anchors_[0].id = 4;
  anchors_[0].has_position = true;
  anchors_[0].state = AnchorState::estimated;
  for (int k = 0; k < 4; ++k) {
    const int ms = 1000 * k, world = k < 2 ? 0 : 3;
    pose(ms);
    path(ms, Vec3(1, 0, 0), world);
    if (k == 0) {
      toldAnchor(ms, 4, Vec3(1, 1, 1));
      path(ms + 1, Vec3(1, 0, 0), world);
      solvers_[0].status = TransformStatus::unique;
    }
    if (k == 2) {
      path(ms + 1, Vec3(50, 0, 0), 0);  // too late
      EXPECT_EQ(peer().transform.answer.status, TransformStatus::degenerate);
      EXPECT_EQ(peer().transform.answer.reason, "it began a new world");
      EXPECT_NE(lines_.back().find("robot 5 began a new world"), std::string::npos);
    }
    range(ms);
    use();
    EXPECT_EQ(solvers_[0].anchors.size(), k < 2 ? 1u : 0u) << "they were in the old world";
  }
  ASSERT_EQ(given().size(), 4u);
  EXPECT_EQ(given()[1].segment_B, 0);
  EXPECT_EQ(given()[2].segment_B, 3);
  EXPECT_EQ(given()[3].segment_B, 3);
}

TEST_F(PeerTracking, ARangeThatBothRobotsTellIsUsedOnce) {
  pose(0);
  range(0);
  range(1);  // the other robot's stamp of it
  path(0, Vec3(1, 0, 0));
  pose(100);
  range(100);
  path(100, Vec3(1, 0, 0));
  use();
  EXPECT_EQ(given().size(), 2u);
  EXPECT_EQ(peer().ranges, 2);
  EXPECT_EQ(peer().doubled, 1);
}

TEST_F(PeerTracking, ARangeOfBeforeThatComesLaterIsUsedInItsPlace) {
  for (int ms = 0; ms <= 300; ms += 100) {
    pose(ms);
    path(ms, Vec3(0.01 * ms, 0, 0));
  }
  now(300);
  range(250);
  range(50);
  use();
  ASSERT_EQ(given().size(), 2u);
  EXPECT_LT(given()[0].range.t, given()[1].range.t);
}

TEST_F(PeerTracking, APathThatIsNoNumberIsNotHeard) {
  path(0, Vec3(std::nan(""), 0, 0));
  path(0, Vec3(1e9, 0, 0));
  EXPECT_EQ(tracker_.unusableBroadcasts(), 2);
  EXPECT_FALSE(tracker_.met());
}

}  // namespace
}  // namespace vir::team
