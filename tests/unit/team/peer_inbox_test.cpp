#include "vir/team/peer_inbox.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace vir::team {
namespace {

constexpr TimeNs kSecond = 1'000'000'000, kNow = 1'700'000'000 * kSecond;

PeerReport report(std::uint32_t sequence, TimeNs t = kNow) {
  PeerReport r;
  r.robot = 5;
  r.session = 77;
  r.sequence = sequence;
  r.t = t;
  r.T_W_B.p = Vec3(1, 2, 3);
  r.covariance.diagonal().setConstant(0.01);
  r.p_B_U = Vec3(0.1, 0, 0.2);
  return r;
}

class Inbox : public testing::Test {
 protected:
  std::optional<HeardReport> add(const PeerReport& r, double arrival_s = 0) {
    return inbox_.add(r, kNow, arrival_s);
  }
  /// Adds what must be refused, for this reason and no other.
  void refuses(const PeerReport& r, ReportDecision why, double arrival_s = 0) {
    const long before = inbox_.count(why);
    EXPECT_FALSE(add(r, arrival_s)) << name(why);
    EXPECT_EQ(inbox_.count(why), before + 1) << name(why);
  }
  std::vector<std::string> lines_;
  PeerInbox inbox_{3, [this](LogLevel, const std::string& text) { lines_.push_back(text); }};
};

TEST_F(Inbox, TakesWhatIsWellFormed) {
  PeerReport r = report(10);
  r.anchors.emplace_back(9, SentPosition{0, Vec3(4, 5, 6), 0.04 * Mat3::Identity()});
  Range to_us{kNow - kSecond, 3, 7.5, 0.05, Vec3::Zero()}, to_another = to_us;
  to_another.anchor = 8;
  r.ranges = {to_us, to_another};
  const auto heard = add(r);
  ASSERT_TRUE(heard);
  EXPECT_EQ(heard->pose.peer, 5);
  EXPECT_EQ(heard->pose.world, 0);
  EXPECT_EQ(heard->pose.T_W_B.p, Vec3(1, 2, 3));
  EXPECT_DOUBLE_EQ(heard->pose.covariance(1, 1), 0.01);
  EXPECT_EQ(heard->pose.p_B_U, Vec3(0.1, 0, 0.2));
  ASSERT_EQ(heard->anchors.size(), 1u);
  EXPECT_EQ(heard->anchors[0].anchor, 9u);
  EXPECT_EQ(heard->anchors[0].sent.t, kNow);
  ASSERT_EQ(heard->ranges.size(), 1u) << "that to another robot is none of this one's business";
  EXPECT_EQ(heard->ranges[0].anchor, 5u);
  EXPECT_EQ(heard->ranges[0].range_m, 7.5);
}

TEST_F(Inbox, NeverBelievesWhatIsNoNumber) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf}) {
    PeerReport r = report(1);
    r.T_W_B.p.y() = bad;
    refuses(r, ReportDecision::not_finite);
    r = report(1);
    r.T_W_B.q.w() = bad;
    refuses(r, ReportDecision::not_finite);
    r = report(1);
    r.covariance(4, 2) = bad;
    refuses(r, ReportDecision::not_finite);
    r = report(1);
    r.p_B_U.x() = bad;
    refuses(r, ReportDecision::not_finite);
  }
  PeerReport r = report(1);
  r.T_W_B.q.coeffs() *= 1.5;
  refuses(r, ReportDecision::not_finite);
  r.T_W_B.q.coeffs().setZero();
  refuses(r, ReportDecision::not_finite);
  EXPECT_TRUE(add(report(1))) << "none of them has been heard";
}

TEST_F(Inbox, NeverBelievesAbsurdCovariances) {
  const auto with = [](auto change) {
    PeerReport r = report(1);
    change(&r);
    return r;
  };
  refuses(with([](PeerReport* r) { r->covariance(0, 0) = -1e-3; }), ReportDecision::absurd);
  refuses(with([](PeerReport* r) { r->covariance(0, 0) = 2e6; }), ReportDecision::absurd);
  refuses(with([](PeerReport* r) { r->covariance(5, 5) = 1e3; }), ReportDecision::absurd);
  refuses(with([](PeerReport* r) { r->covariance(0, 1) = r->covariance(1, 0) = 0.02; }),
          ReportDecision::absurd);
  refuses(with([](PeerReport* r) {
            r->covariance(0, 0) = 0;
            r->covariance(0, 1) = r->covariance(1, 0) = 1e-3;
          }),
          ReportDecision::absurd);
  refuses(with([](PeerReport* r) { r->T_W_B.p.x() = 1e7; }), ReportDecision::absurd);
  refuses(with([](PeerReport* r) { r->p_B_U.x() = 1e3; }), ReportDecision::absurd);
  // Who says that it knows exactly is taken at a millimetre.
  const auto exact = add(with([](PeerReport* r) { r->covariance.setZero(); }));
  ASSERT_TRUE(exact);
  EXPECT_DOUBLE_EQ(exact->pose.covariance(2, 2), 1e-6);
}

TEST_F(Inbox, LeavesOutAnchorsAndRangesThatAreNone) {
  PeerReport r = report(1);
  r.anchors.emplace_back(1, SentPosition{0, Vec3(std::nan(""), 0, 0), Mat3::Identity()});
  r.anchors.emplace_back(2, SentPosition{0, Vec3(1, 0, 0), -Mat3::Identity()});
  r.anchors.emplace_back(3, SentPosition{0, Vec3(1, 0, 0), Mat3::Identity()});
  for (const double bad : {std::nan(""), -1.0, 0.0, 1e9}) {
    r.ranges.push_back({kNow, 3, bad, 0.05, Vec3::Zero()});
    r.ranges.push_back({kNow, 3, 4, bad, Vec3::Zero()});
  }
  r.ranges.push_back({kNow + kSecond, 3, 4, 0.05, Vec3::Zero()});
  r.ranges.push_back({INT64_MIN, 3, 4, 0.05, Vec3::Zero()});
  const auto heard = add(r);
  ASSERT_TRUE(heard);
  ASSERT_EQ(heard->anchors.size(), 1u);
  EXPECT_EQ(heard->anchors[0].anchor, 3u);
  EXPECT_TRUE(heard->ranges.empty());
}

TEST_F(Inbox, OfWhatIsToldOfTheTeamNonsenseIsLeftOut) {
  PeerReport r = report(10);
  r.team = TeamTold{CommonFrame{{1, 2, 3}, kNow - kSecond, kNow, {0.5, Vec3(1, 2, 3)}}, {}};
  const ToldTransform good{{8, 9, 1}, {-1, Vec3(4, 5, 6)}, 0.01 * Eigen::Matrix4d::Identity()};
  ToldTransform nan = good, far = good, negative = good, unsure = good;
  nan.T_own_from.yaw_rad = std::nan("");
  far.T_own_from.t_m.y() = 1e9;
  negative.covariance(2, 2) = -1;
  unsure.covariance(0, 0) = std::numeric_limits<double>::infinity();
  r.team->transforms = {nan, far, good, negative, unsure};
  const auto heard = add(r);
  ASSERT_TRUE(heard && heard->team);
  EXPECT_EQ(heard->world, (WorldId{5, 77, 0}));
  ASSERT_TRUE(heard->team->frame);
  EXPECT_EQ(heard->team->frame->founder, (WorldId{1, 2, 3}));
  ASSERT_EQ(heard->team->transforms.size(), 1u);
  EXPECT_EQ(heard->team->transforms[0].from, good.from);
  EXPECT_EQ(heard->team->transforms[0].T_own_from.t_m, Vec3(4, 5, 6));
  // A frame that was founded in the future, or lies nowhere.
  r.sequence = 11;
  r.team->frame->founded = kNow + 3600 * kSecond;
  EXPECT_FALSE(add(r)->team->frame);
  r.sequence = 12;
  r.team->frame->founded = kNow;
  r.team->frame->T_C_own.t_m.z() = std::nan("");
  EXPECT_FALSE(add(r)->team->frame);
  for (int i = 0; i < 100; ++i) r.team->transforms.push_back(good);
  r.sequence = 13;
  EXPECT_EQ(add(r)->team->transforms.size(), kMostToldTransforms);
  EXPECT_FALSE(add(report(14))->team) << "it is not in every report";
}

TEST_F(Inbox, AnotherVersionAndTheOwnNumberAreSaidOnce) {
  PeerReport other = report(1), own = report(1);
  other.version = 2;
  own.robot = 3;
  for (int i = 0; i < 3; ++i) {
    refuses(other, ReportDecision::other_version);
    refuses(own, ReportDecision::own_number);
  }
  ASSERT_EQ(lines_.size(), 2u);
  EXPECT_NE(lines_[0].find("version 2"), std::string::npos) << lines_[0];
  EXPECT_NE(lines_[1].find("Dds.robot"), std::string::npos) << lines_[1];
}

TEST_F(Inbox, OtherClocks) {
  refuses(report(1, kNow + 600'000'000), ReportDecision::other_clock);
  refuses(report(1, INT64_MAX), ReportDecision::other_clock);
  refuses(report(1, INT64_MIN), ReportDecision::other_clock);
  refuses(report(1, kNow - 2 * kSecond - 1), ReportDecision::late);
  EXPECT_TRUE(add(report(1, kNow + 400'000'000)));
  EXPECT_TRUE(add(report(2, kNow - 2 * kSecond)));
  EXPECT_FALSE(inbox_.add(report(3), std::nullopt, 0)) << "before there is a time of its own";
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_NE(lines_[0].find("robot 5 tells is stamped 0.6 s ahead"), std::string::npos) << lines_[0];
}

TEST_F(Inbox, RepeatedReorderedAndLost) {
  EXPECT_TRUE(add(report(10)));
  refuses(report(10), ReportDecision::repeated);
  EXPECT_TRUE(add(report(14)));
  EXPECT_EQ(inbox_.lost(), 3);
  EXPECT_TRUE(add(report(12)));
  EXPECT_EQ(inbox_.lost(), 2);
  EXPECT_EQ(inbox_.reordered(), 1);
  refuses(report(12), ReportDecision::repeated);
  EXPECT_TRUE(add(report(1000)));
  refuses(report(500), ReportDecision::late);
  // It counts up beyond its last number.
  PeerReport last = report(0xffffffffu);
  last.robot = 6;
  EXPECT_TRUE(add(last));
  last.sequence = 0;
  EXPECT_TRUE(add(last));
}

TEST_F(Inbox, ARestartIsAnotherWorld) {
  EXPECT_EQ(add(report(10), 0)->pose.world, 0);
  PeerReport again = report(0);
  again.session = 78;
  refuses(again, ReportDecision::same_number, 0.9);
  EXPECT_EQ(lines_.size(), 1u);
  EXPECT_EQ(add(again, 1.1)->pose.world, 1);
  refuses(report(11), ReportDecision::old_world, 1.2);
  refuses(report(11), ReportDecision::old_world, 9);
  again.sequence = 1;
  again.segment = 1;
  EXPECT_EQ(add(again, 9.1)->pose.world, 2) << "its estimator began anew";
  again.sequence = 2;
  again.segment = 0;
  refuses(again, ReportDecision::old_world, 9.2);
}

TEST_F(Inbox, MoreRobotsThanItFollows) {
  for (std::uint32_t robot = 100; robot < 132; ++robot) {
    PeerReport r = report(1);
    r.robot = robot;
    EXPECT_TRUE(add(r));
  }
  refuses(report(1), ReportDecision::too_many_robots);
  ASSERT_EQ(inbox_.counters().size(), 2u);
  EXPECT_EQ(inbox_.counters()[0], (std::pair<std::string, long>("accepted", 32)));
  EXPECT_EQ(inbox_.counters()[1], (std::pair<std::string, long>("too_many_robots", 1)));
}

}  // namespace
}  // namespace vir::team
