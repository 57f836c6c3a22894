#include "vir/team/meeting.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fake_solver.h"

namespace vir::team {
namespace {

/// Standing for two seconds, with a range to every robot of `peers` every 0.1 s.
RobotRecord robot(const std::string& name, int id, const std::vector<int>& peers) {
  RobotRecord out;
  out.name = name;
  out.id = id;
  for (int k = 0; k <= 20; ++k) {
    KnownPose p;
    p.t = fromSeconds(0.1 * k);
    out.poses.push_back(p);
    for (const int peer : peers) {
      out.peer_ranges.push_back(
          {p.t, static_cast<std::uint32_t>(peer), 3.0 + peer, 0.05, Vec3::Zero()});
    }
  }
  return out;
}

struct Told {
  std::vector<std::string> warnings, rest;
  LogSink sink() {
    return [this](LogLevel level, const std::string& text) {
      (level == LogLevel::warning ? warnings : rest).push_back(text);
    };
  }
};

TEST(Meeting, EveryPairHasASolverAndEveryLoopIsChecked) {
  std::deque<test::SolverNotes> solvers;
  Told told;
  const Meeting m = meet({robot("A", 0, {1, 2}), robot("B", 1, {0, 2}), robot("C", 2, {0})}, {},
                         test::fakeSolvers(&solvers, TransformStatus::unique), told.sink());
  EXPECT_EQ(solvers.size(), 3u);
  ASSERT_EQ(m.pairs.size(), 3u);
  EXPECT_EQ(m.pairs[2].transform.from, "C");
  EXPECT_EQ(m.pairs[2].transform.to, "B");
  ASSERT_EQ(m.map.loops.size(), 1u);
  EXPECT_TRUE(m.map.loops[0].consistent) << "three times the identity";
  EXPECT_EQ(m.map.root, "A");
  EXPECT_EQ(m.map.T_root.size(), 3u);
  EXPECT_TRUE(told.warnings.empty()) << told.warnings.front();
  ASSERT_EQ(told.rest.size(), 1u) << "there is no odometry to solve jointly with";
}

TEST(Meeting, SaysThatALoopContradictsItself) {
  std::deque<test::SolverNotes> solvers;
  const auto create = [&](const LogSink& log) {
    auto solver = test::fakeSolvers(&solvers, TransformStatus::unique)(log);
    if (solvers.size() == 2) solvers.back().T.t_m = Vec3(40, 0, 0);
    return solver;
  };
  Told told;
  const Meeting m = meet({robot("A", 0, {1, 2}), robot("B", 1, {0, 2}), robot("C", 2, {0})}, {},
                         create, told.sink());
  ASSERT_EQ(told.warnings.size(), 2u);
  EXPECT_NE(told.warnings[0].find("contradict each other"), std::string::npos);
  EXPECT_NE(told.warnings[1].find("left out"), std::string::npos);
  EXPECT_EQ(m.map.left_out.size(), 1u);
  EXPECT_EQ(m.map.T_root.size(), 3u) << "two transforms are enough";
}

TEST(Meeting, SaysOnceThatNobodyKnowsARobotsAntenna) {
  std::deque<test::SolverNotes> solvers;
  Told told;
  MeetingOptions options;
  options.solve_jointly = false;
  const Meeting m = meet({robot("A", 0, {}), robot("B", 1, {0})}, options,
                         test::fakeSolvers(&solvers, TransformStatus::unique), told.sink());
  EXPECT_EQ(m.pairs[0].ranges.antenna_unknown, 21);
  ASSERT_EQ(told.warnings.size(), 1u);
  EXPECT_NE(told.warnings[0].find("the recording of robot A has no range in it"), std::string::npos)
      << told.warnings[0];
  EXPECT_TRUE(told.rest.empty());
}

TEST(Meeting, SaysHowManyRangesHadNoPose) {
  std::deque<test::SolverNotes> solvers;
  Told told;
  RobotRecord late = robot("A", 0, {1});
  late.poses.erase(late.poses.begin(), late.poses.begin() + 5);
  MeetingOptions options;
  options.solve_jointly = false;
  const Meeting m = meet({late, robot("B", 1, {0})}, options,
                         test::fakeSolvers(&solvers, TransformStatus::degenerate), told.sink());
  ASSERT_EQ(told.warnings.size(), 1u);
  EXPECT_EQ(told.warnings[0],
            "10 ranges between A and B came when one of them had no pose: not used");
  EXPECT_EQ(m.map.T_root.size(), 1u) << "nobody is tied to anybody";
}

}  // namespace
}  // namespace vir::team
