#include "vir/team/team_mapper.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vir::team {
namespace {

/// Robots that tell each other of pairs without errors.
class Team {
 public:
  struct Member {
    WorldId id;
    WorldTransform T_G;  // from its world to the ground
    bool running = true;
    TeamMapper mapper;
  };

  explicit Team(int robots) : members_(static_cast<std::size_t>(robots)) {
    for (std::size_t i = 0; i < members_.size(); ++i) {
      const double k = static_cast<double>(i);
      members_[i].id = {static_cast<std::uint32_t>(i), 100 + i, 0};
      members_[i].T_G = {0.6 * k - 1, Vec3(4 * std::sin(k), 3 * std::cos(2 * k), 0.1 * k)};
    }
  }
  /// Kills a robot and starts it again elsewhere.
  void restart(std::size_t i) {
    members_[i].mapper = TeamMapper();
    members_[i].id.session += 1000;
    members_[i].T_G = {2.0, Vec3(-7, 1, 0)};
    tied_[i] = false;
  }
  void tie(std::size_t i, bool tied) { tied_[i] = tied; }
  Member& at(std::size_t i) { return members_[i]; }

  /// Neighbours in a ring range to each other; everybody hears everybody.
  void second() {
    now_ += 1'000'000'000;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      Member& m = members_[i];
      if (!m.running) continue;
      std::vector<ToldTransform> transforms;
      for (const std::size_t j :
           {(i + 1) % members_.size(), (i + members_.size() - 1) % members_.size()}) {
        if (!members_[j].running || !tied(i) || !tied(j)) continue;
        const Member& o = members_[j];
        transforms.push_back({o.id, m.T_G.inverse() * o.T_G, 1e-4 * Eigen::Matrix4d::Identity()});
      }
      m.mapper.setOwn(m.id, now_, transforms);
    }
    for (Member& m : members_) {
      for (const Member& o : members_) {
        if (!m.running || !o.running || m.id == o.id) continue;
        m.mapper.hear(o.id, now_, o.mapper.told());
      }
    }
    for (Member& m : members_) {
      if (m.running) m.mapper.solve(now_);
    }
  }
  void seconds(int n) {
    for (int i = 0; i < n; ++i) second();
  }
  /// From the common frame, as robot `i` has it, to the ground.
  WorldTransform frameOf(std::size_t i) const {
    return members_[i].T_G * members_[i].mapper.frame()->T_C_own.inverse();
  }
  static double apart(const WorldTransform& a, const WorldTransform& b) {
    return (a.t_m - b.t_m).norm() + std::abs(wrapAngle(a.yaw_rad - b.yaw_rad));
  }

 private:
  bool tied(std::size_t i) const {
    const auto it = tied_.find(i);
    return it == tied_.end() || it->second;
  }
  std::vector<Member> members_;
  std::map<std::size_t, bool> tied_;
  TimeNs now_ = 1'600'000'000'000'000'000;
};

TEST(TeamMapper, EverybodyKnowsWhereEverybodyIsInTheLowestNumbersWorld) {
  Team team(10);
  team.seconds(4);
  for (std::size_t i = 0; i < 10; ++i) {
    const TeamMapper& m = team.at(i).mapper;
    EXPECT_EQ(m.frame()->founder.robot, 0u) << i;
    EXPECT_LT(Team::apart(team.frameOf(i), team.at(0).T_G), 1e-9) << i;
    ASSERT_EQ(m.places().size(), 10u) << i;
    for (const auto& [robot, place] : m.places()) {
      const WorldTransform truth = team.at(0).T_G.inverse() * team.at(robot).T_G;
      EXPECT_LT(Team::apart(place.T_C_world, truth), 1e-9) << i << " of " << robot;
    }
    EXPECT_TRUE(m.leftOut().empty());
  }
}

TEST(TeamMapper, AloneARobotIsInItsOwnFrame) {
  Team team(1);
  EXPECT_TRUE(team.at(0).mapper.places().empty());
  EXPECT_FALSE(team.at(0).mapper.told().frame);
  team.second();
  ASSERT_EQ(team.at(0).mapper.places().size(), 1u);
  EXPECT_LT(Team::apart(team.frameOf(0), team.at(0).T_G), 1e-12);
}

TEST(TeamMapper, TheFrameSurvivesARestartOfItsFounder) {
  Team team(4);
  team.seconds(5);
  const WorldTransform frame = team.frameOf(2);
  team.restart(0);
  team.seconds(3);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_LT(Team::apart(team.frameOf(i), frame), 1e-9) << i << " while it is not tied";
    EXPECT_EQ(team.at(i).mapper.places().count(0), 0u) << i;
  }
  team.tie(0, true);
  team.seconds(4);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT(Team::apart(team.frameOf(i), frame), 1e-9) << i;
    ASSERT_EQ(team.at(i).mapper.places().count(0), 1u) << i;
    EXPECT_EQ(team.at(i).mapper.frame()->founder.session, 100u) << "the old one's";
    const WorldTransform truth = frame.inverse() * team.at(0).T_G;
    EXPECT_LT(Team::apart(team.at(i).mapper.places().at(0).T_C_world, truth), 1e-9) << i;
  }
  // Then the one that has held it longest as well, and another one.
  for (const std::size_t i : {1u, 2u}) {
    team.restart(i);
    team.seconds(2);
    team.tie(i, true);
    team.seconds(4);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT(Team::apart(team.frameOf(i), frame), 1e-9) << i;
    EXPECT_EQ(team.at(i).mapper.places().size(), 4u) << i;
  }
}

TEST(TeamMapper, TwoTeamsThatMeetHaveTheLowestNumbersFrame) {
  Team team(5);
  team.tie(0, false);
  team.seconds(5);
  EXPECT_EQ(team.at(3).mapper.frame()->founder.robot, 1u);
  team.tie(0, true);
  team.seconds(5);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(team.at(i).mapper.frame()->founder.robot, 0u) << i;
    EXPECT_LT(Team::apart(team.frameOf(i), team.at(0).T_G), 1e-9) << i;
  }
}

TEST(TeamMapper, WhoIsSilentForLongIsForgotten) {
  Team team(3);
  team.seconds(3);
  team.at(2).running = false;
  team.seconds(40);
  EXPECT_EQ(team.at(0).mapper.places().count(2), 0u) << "nobody ties its world any more";
  team.at(2).running = true;
  team.seconds(2);
  EXPECT_EQ(team.at(0).mapper.places().size(), 3u);
}

TEST(TeamMapper, OldNewsAndCrowdsChangeNothing) {
  TeamMapper m;
  m.setOwn({5, 1, 0}, 1000, {});
  TeamTold told;
  told.transforms.push_back({{5, 1, 0}, {0, Vec3(1, 0, 0)}, 1e-4 * Eigen::Matrix4d::Identity()});
  m.hear({7, 1, 0}, 2000, told);
  m.hear({7, 9, 9}, 1500, TeamTold());
  m.solve(2000);
  ASSERT_EQ(m.places().count(7), 1u);
  EXPECT_NEAR(m.places().at(7).T_C_world.t_m.x(), -1, 1e-12);
  for (std::uint32_t i = 100; i < 200; ++i) {
    told.transforms[0].from = {5, 1, 0};
    m.hear({i, 1, 0}, 2000, told);
  }
  m.solve(2000);
  EXPECT_EQ(m.places().size(), 33u);
  EXPECT_EQ(m.places().count(7), 1u);
}

}  // namespace
}  // namespace vir::team
