#include "vir/team/team_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "vir_test_noise.h"

namespace vir::team {
namespace {

const Eigen::Vector4d kNone = Eigen::Vector4d::Zero();

/// Ten robots' worlds in a common one.
WorldTransform worldOf(int robot) {
  return {0.7 * robot - 2, Vec3(5 * std::sin(robot), 4 * std::cos(2 * robot), 0.1 * robot)};
}

std::string nameOf(int robot) { return std::string(1, static_cast<char>('A' + robot)); }

TransformEdge edge(int from, int to, const Eigen::Vector4d& error, double sigma = 0.05) {
  TransformEdge e;
  e.from = nameOf(from);
  e.to = nameOf(to);
  e.T_to_from = worldOf(to).inverse() * worldOf(from);
  e.T_to_from.yaw_rad += error[0];
  e.T_to_from.t_m += error.tail<3>();
  e.covariance = sigma * sigma * Eigen::Matrix4d::Identity();
  return e;
}

Eigen::Vector4d errorOf(const TeamGraph& g, int robot, int root = 0) {
  const WorldTransform truth = worldOf(root).inverse() * worldOf(robot);
  const WorldTransform& T = g.worlds.at(nameOf(robot)).T_root;
  Eigen::Vector4d e;
  e << wrapAngle(T.yaw_rad - truth.yaw_rad), T.t_m - truth.t_m;
  return e;
}

TEST(TeamGraph, TrueTransformsPlaceEverybodyExactly) {
  std::vector<TransformEdge> edges;
  for (int i = 0; i < 10; ++i) {
    for (int j = i + 1; j < 10; j += 2) edges.push_back(edge(i, j, kNone));
  }
  const TeamGraph g = solveTeam("A", edges);
  ASSERT_EQ(g.worlds.size(), 10u);
  EXPECT_EQ(g.used.size(), edges.size());
  EXPECT_TRUE(g.left_out.empty());
  EXPECT_EQ(g.redundant, 4 * (static_cast<int>(edges.size()) - 9));
  EXPECT_NEAR(g.chi2, 0, 1e-9);
  for (int i = 0; i < 10; ++i) EXPECT_LT(errorOf(g, i).norm(), 1e-9) << i;
}

TEST(TeamGraph, WhatIsSaidOfTheErrorsIsHonest) {
  double nees = 0, chi2 = 0, one_way = 0, all = 0;
  const int runs = 200;
  for (int run = 0; run < runs; ++run) {
    test::Noise noise(static_cast<std::uint64_t>(run));
    std::vector<TransformEdge> edges;
    for (int i = 0; i < 5; ++i) {
      for (int j = i + 1; j < 5; ++j) {
        Eigen::Vector4d e;
        for (int k = 0; k < 4; ++k) e[k] = 0.02 * noise.normal();
        edges.push_back(edge(j, i, e, 0.02));
      }
    }
    const TeamGraph g = solveTeam("A", edges);
    ASSERT_EQ(g.used.size(), 10u) << run;
    const Eigen::Vector4d e = errorOf(g, 4);
    nees += e.dot(g.worlds.at("E").covariance.ldlt().solve(e)) / runs;
    chi2 += g.chi2 / g.redundant / runs;
    all += e.squaredNorm();
    one_way += 4 * 0.02 * 0.02;
  }
  EXPECT_NEAR(nees, 4, 0.6);
  EXPECT_NEAR(chi2, 1, 0.1);
  EXPECT_LT(all, 0.6 * one_way) << "the ways round tell as well";
}

TEST(TeamGraph, AWrongTransformThatMostLoopsSpeakAgainstIsLeftOut) {
  std::vector<TransformEdge> edges;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const bool wrong = i == 0 && j == 3;
      // That it is believed to be the best of all does not help it.
      edges.push_back(
          edge(i, j, wrong ? Eigen::Vector4d(2, 1, -3, 0) : kNone, wrong ? 0.01 : 0.05));
    }
  }
  const TeamGraph g = solveTeam("A", edges);
  ASSERT_EQ(g.left_out.size(), 1u);
  EXPECT_EQ(g.left_out[0].from + g.left_out[0].to, "AD");
  ASSERT_EQ(g.worlds.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_LT(errorOf(g, i).norm(), 1e-9) << i;
  EXPECT_EQ(std::count_if(g.loops.begin(), g.loops.end(),
                          [](const TransformLoop& l) { return !l.consistent; }),
            2);
}

TEST(TeamGraph, ALongLoopThatDoesNotCloseIsNoticed) {
  // A ring of six has no loop of three.
  std::vector<TransformEdge> edges;
  for (int i = 0; i < 6; ++i) {
    edges.push_back(
        edge(i, (i + 1) % 6, i == 2 ? Eigen::Vector4d(0.5, 4, 0, 0) : kNone, i == 2 ? 0.2 : 0.05));
  }
  const TeamGraph g = solveTeam("A", edges);
  EXPECT_TRUE(g.loops.empty());
  ASSERT_EQ(g.left_out.size(), 1u);
  EXPECT_EQ(g.left_out[0].from, "C") << "the least certain, which bears most of the misfit";
  for (int i = 0; i < 6; ++i) EXPECT_LT(errorOf(g, i).norm(), 1e-9) << i;
}

TEST(TeamGraph, WhoIsNotTiedIsNotPlacedAndNonsenseIsLeftOut) {
  std::vector<TransformEdge> edges{edge(1, 0, kNone), edge(3, 2, kNone), edge(2, 0, kNone)};
  edges[2].T_to_from.t_m.x() = NAN;
  edges.push_back(edge(4, 0, kNone));
  edges[3].covariance(2, 2) = -1;
  const TeamGraph g = solveTeam("A", edges);
  EXPECT_EQ(g.worlds.size(), 2u);
  EXPECT_EQ(g.used.size(), 1u);
  EXPECT_EQ(g.left_out.size(), 2u);
  const TeamGraph alone = solveTeam("Z", {});
  ASSERT_EQ(alone.worlds.size(), 1u);
  EXPECT_EQ(alone.worlds.at("Z").covariance, Eigen::Matrix4d(Eigen::Matrix4d::Zero()));
}

TEST(TeamGraph, TheOrderOfTheEdgesDoesNotMatter) {
  test::Noise noise(3);
  std::vector<TransformEdge> edges;
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j) {
      Eigen::Vector4d e;
      for (int k = 0; k < 4; ++k) e[k] = 0.05 * noise.normal();
      edges.push_back(edge(i, j, e));
    }
  }
  const TeamGraph one = solveTeam("C", edges);
  std::reverse(edges.begin(), edges.end());
  const TeamGraph other = solveTeam("C", edges);
  for (const auto& [name, world] : one.worlds) {
    EXPECT_EQ(world.T_root.t_m, other.worlds.at(name).T_root.t_m) << name;
  }
}

}  // namespace
}  // namespace vir::team
