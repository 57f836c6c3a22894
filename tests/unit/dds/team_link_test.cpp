/// The team over DDS, with robots that are processes of their own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <map>
#include <thread>

#include "cyclone/cyclone_link.h"
#include "cyclone/report_sample.h"
#include "program.h"
#include "team_on_a_line.h"
#include "vir/team/peer_inbox.h"

namespace vir::dds {
namespace {

using test::ownDomain;
using test::Program;

std::string ownTeam() { return "team" + std::to_string(getpid()); }

std::vector<std::string> robot(int number, int reports, const std::string& fault = "",
                               const std::string& team = ownTeam(), int domain = ownDomain()) {
  return {
      std::to_string(number), std::to_string(domain), team, std::to_string(reports), "100", fault};
}

class TeamLink : public testing::Test {
 protected:
  TeamLink() {
    LinkOptions options;
    options.robot = 3;
    options.domain = ownDomain();
    options.team = ownTeam();
    link_ = openCycloneLink(options);
  }
  void takeUntil(const std::function<bool()>& enough, double most_s = 10) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(most_s);
    while (!enough() && std::chrono::steady_clock::now() < end) {
      for (team::PeerReport& r : link_->take()) heard_.push_back(std::move(r));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  /// All that a robot with `fault` says, judged.
  void judge(const std::string& fault, int reports) {
    heard_.clear();
    Program other("vir_test_dds_robot", robot(5, reports, fault));
    EXPECT_EQ(other.end(), 0);
    takeUntil([] { return false; }, 0.1);
    for (const team::PeerReport& r : heard_) {
      accepted_ += inbox_.add(r, test::kLineStart + 50'000'000 * 40, 0).has_value() ? 1 : 0;
    }
  }

  std::unique_ptr<Link> link_;
  std::vector<team::PeerReport> heard_;
  team::PeerInbox inbox_{3, {}};
  int accepted_ = 0;
};

TEST_F(TeamLink, TellsAllOfAReport) {
  Program other("vir_test_dds_robot", robot(5, 50));
  takeUntil([this] { return heard_.size() >= 50; });
  EXPECT_EQ(other.end(), 0);
  ASSERT_EQ(heard_.size(), 50u);
  for (int i = 0; i < 50; ++i) {
    const team::PeerReport sent = test::reportOnALine(5, i), &r = heard_[i];
    EXPECT_EQ(r.version, 1);
    EXPECT_EQ(r.robot, 5u);
    EXPECT_EQ(r.sequence, sent.sequence);
    EXPECT_EQ(r.session, heard_[0].session);
    EXPECT_EQ(r.t, sent.t);
    EXPECT_EQ(r.T_W_B.p, sent.T_W_B.p);
    EXPECT_EQ(r.T_W_B.q.coeffs(), sent.T_W_B.q.coeffs());
    EXPECT_EQ(r.covariance, sent.covariance);
    EXPECT_EQ(r.p_B_U, sent.p_B_U);
    ASSERT_EQ(r.anchors.size(), 1u);
    EXPECT_EQ(r.anchors[0].first, 7u);
    EXPECT_EQ(r.anchors[0].second.p_W, Vec3(4, 5, 6));
    EXPECT_EQ(r.anchors[0].second.covariance, 0.5 * Mat3::Identity());
    ASSERT_EQ(r.ranges.size(), 1u);
    EXPECT_EQ(r.ranges[0].t, sent.ranges[0].t);
    EXPECT_EQ(r.ranges[0].anchor, 3u);
    EXPECT_EQ(r.ranges[0].range_m, 7.25);
    EXPECT_EQ(r.ranges[0].sigma_m, 0.125);
    ASSERT_EQ(r.team.has_value(), i % 10 == 0) << i;
    if (!r.team) continue;
    ASSERT_TRUE(r.team->frame);
    EXPECT_EQ(r.team->frame->founder, sent.team->frame->founder);
    EXPECT_EQ(r.team->frame->founded, sent.team->frame->founded);
    EXPECT_EQ(r.team->frame->held_since, sent.team->frame->held_since);
    EXPECT_EQ(r.team->frame->T_C_own.yaw_rad, 0.25);
    EXPECT_EQ(r.team->frame->T_C_own.t_m, Vec3(7, 8, 9));
    ASSERT_EQ(r.team->transforms.size(), 1u);
    EXPECT_EQ(r.team->transforms[0].from, sent.team->transforms[0].from);
    EXPECT_EQ(r.team->transforms[0].T_own_from.yaw_rad, -1.5);
    EXPECT_EQ(r.team->transforms[0].T_own_from.t_m, Vec3(1, 2, 3));
    EXPECT_EQ(r.team->transforms[0].covariance, sent.team->transforms[0].covariance);
  }
}

TEST_F(TeamLink, SaysNothingToItself) {
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(link_->send(test::reportOnALine(3, i)));
  takeUntil([this] { return !heard_.empty(); }, 0.5);
  EXPECT_TRUE(heard_.empty());
  EXPECT_EQ(link_->listeners(), 0);
}

TEST_F(TeamLink, ARobotThatIsKilledIsHeardAgainWhenItIsBack) {
  {
    Program other("vir_test_dds_robot", robot(5, 100000));
    takeUntil([this] { return heard_.size() >= 20; });
    EXPECT_EQ(other.end(SIGKILL), -SIGKILL);
  }
  ASSERT_GE(heard_.size(), 20u);
  const std::uint64_t before = heard_[0].session;
  takeUntil([] { return false; }, 0.1);
  heard_.clear();
  Program again("vir_test_dds_robot", robot(5, 100000));
  takeUntil([this] { return heard_.size() >= 20; });
  ASSERT_GE(heard_.size(), 20u);
  EXPECT_NE(heard_[0].session, before);
  EXPECT_EQ(heard_[0].sequence, 0u);
}

TEST_F(TeamLink, FourRobotsHearEachOther) {
  std::vector<std::unique_ptr<Program>> others;
  for (int number = 5; number < 8; ++number) {
    others.push_back(std::make_unique<Program>("vir_test_dds_robot", robot(number, 400)));
  }
  // They begin when the first of the others hears them, which need not be this one.
  std::map<std::uint32_t, int> count;
  takeUntil([&] {
    count.clear();
    for (const team::PeerReport& r : heard_) ++count[r.robot];
    return count[5] >= 100 && count[6] >= 100 && count[7] >= 100;
  });
  EXPECT_EQ(count.size(), 3u);
  for (const auto& [number, reports] : count) EXPECT_GE(reports, 100) << number;
}

TEST_F(TeamLink, AnotherTeamAndAnotherDomainAreNotHeard) {
  // Who is not heard has no listener, and waits for one: these would go on for long.
  Program team("vir_test_dds_robot", robot(5, 100000, "", "others"));
  Program domain("vir_test_dds_robot", robot(6, 100000, "", ownTeam(), 101));
  takeUntil([this] { return !heard_.empty(); }, 2);
  EXPECT_TRUE(heard_.empty());
  EXPECT_EQ(link_->listeners(), 0);
}

TEST_F(TeamLink, AStrangerWithAnotherTypeIsNotHeard) {
  Program stranger("vir_test_dds_stranger", {std::to_string(ownDomain()), ownTeam()});
  Program other("vir_test_dds_robot", robot(5, 100));
  takeUntil([this] { return heard_.size() >= 100; });
  EXPECT_EQ(stranger.end(), 0);
  ASSERT_EQ(heard_.size(), 100u) << "the robot is heard beside it";
  for (const team::PeerReport& r : heard_) EXPECT_EQ(r.robot, 5u);
}

TEST_F(TeamLink, WhatIsWrongIsCountedAndNeverBelieved) {
  judge("nan", 30);
  EXPECT_EQ(inbox_.count(team::ReportDecision::not_finite), 30);
  judge("covariance", 30);
  EXPECT_EQ(inbox_.count(team::ReportDecision::absurd), 30);
  judge("version", 30);
  EXPECT_EQ(inbox_.count(team::ReportDecision::other_version), 30);
  judge("clock", 30);
  EXPECT_EQ(inbox_.count(team::ReportDecision::other_clock), 30);
  EXPECT_EQ(accepted_, 0);
}

TEST_F(TeamLink, RepeatedReportsAreTakenOnce) {
  judge("duplicated", 30);
  EXPECT_EQ(heard_.size(), 60u);
  EXPECT_EQ(accepted_, 30);
  EXPECT_EQ(inbox_.count(team::ReportDecision::repeated), 30);
}

TEST_F(TeamLink, ReportsInAnotherOrderAreTaken) {
  judge("reordered", 30);
  EXPECT_EQ(accepted_, 30);
  EXPECT_EQ(inbox_.reordered(), 15);
  EXPECT_EQ(inbox_.lost(), 0);
}

TEST(OpenLink, SaysWhatIsMissing) {
  LinkOptions options;
  options.domain = ownDomain();
  options.security = "/nowhere";
  try {
    openCycloneLink(options);
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("/nowhere/identity_ca.cert.pem"), std::string::npos)
        << e.what();
  }
  options.security.clear();
  options.interface = "nosuch0";
  try {
    openCycloneLink(options);
    FAIL();
  } catch (const std::runtime_error& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("on interface nosuch0"), std::string::npos) << text;
    EXPECT_NE(text.find("does not match"), std::string::npos) << text;
  }
  // What failed leaves nothing behind.
  options.interface = "lo";
  EXPECT_TRUE(openCycloneLink(options));
}

TEST(ReportSample, LeavesOutWhatIsBeyondItsBounds) {
  team::PeerReport r = test::reportOnALine(5, 0);
  for (int i = 0; i < 200; ++i) {
    r.anchors.push_back(r.anchors[0]);
    r.ranges.push_back(r.ranges[0]);
    r.team->transforms.push_back(r.team->transforms[0]);
  }
  const ReportSample sample(r);
  EXPECT_EQ(sample.sample().anchors._length, 64u);
  EXPECT_EQ(sample.sample().ranges._length, 32u);
  EXPECT_EQ(sample.sample().transforms._length, 32u);
}

}  // namespace
}  // namespace vir::dds
