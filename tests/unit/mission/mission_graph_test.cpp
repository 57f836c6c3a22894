#include "vir/mission/mission_graph.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rounds.h"
#include "vir/core/angles.h"

namespace vir::mission {
namespace {

using vir_test::ateOf;
using vir_test::makeRounds;
using vir_test::Rounds;
using vir_test::RoundsOptions;
using vir_test::trueLoop;

MissionGraph graphOf(const Rounds& r) {
  MissionGraph graph({});
  for (const PathNode& n : r.path) graph.add(n);
  return graph;
}

struct Flown {
  double odometry = 0, causal = 0, smoothed = 0;
  LoopCounts counts;
  int false_accepted = 0, false_offered = 0;
  std::vector<StampedPose> path;
};

/// As in a run: keyframe by keyframe, a second look every few, a share of them false.
Flown fly(const Rounds& r, double share_false, std::uint64_t seed) {
  MissionGraph graph({});
  Random random(seed);
  std::vector<StampedPose> causal, odometry;
  std::vector<std::size_t> lies;
  for (std::size_t i = 0; i < r.path.size(); ++i) {
    graph.add(r.path[i]);
    const int k = static_cast<int>(i);
    if (k >= r.per_round && k % 6 == 0) {
      const int round =
          1 + static_cast<int>(random.below(static_cast<std::uint64_t>(k / r.per_round)));
      Loop loop = trueLoop(r, k - round * r.per_round, k, &random);
      if (random.uniform() < share_false) {
        // Another place that looks the same: the shelf beside.
        loop.T_older_newer.p += Vec3(random.uniform() < 0.5 ? 2.5 : -2.5, 0, 0);
        lies.push_back(graph.loops().size());
      }
      graph.offer(loop);
      if (graph.solveDue()) graph.solve();
    }
    causal.push_back({r.path[i].t, graph.correction().pose() * r.path[i].T_W_B});
    odometry.push_back({r.path[i].t, r.path[i].T_W_B});
  }
  graph.solve();
  Flown out;
  out.path = graph.path();
  out.odometry = ateOf(odometry, r);
  out.causal = ateOf(causal, r);
  out.smoothed = ateOf(out.path, r);
  out.counts = graph.counts();
  out.false_offered = static_cast<int>(lies.size());
  for (const std::size_t k : lies) {
    if (graph.loops()[k].state == LoopState::accepted) ++out.false_accepted;
  }
  return out;
}

TEST(MissionGraph, TenRoundsWithLoops) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    RoundsOptions o;
    o.seed = seed;
    const Flown f = fly(makeRounds(o), 0, seed);
    EXPECT_LT(f.smoothed, f.odometry / 4) << seed;
    EXPECT_LT(f.causal, f.odometry / 2) << seed;
    EXPECT_LT(f.smoothed, 0.15) << seed;
    EXPECT_EQ(f.counts.taken_back, 0) << seed;
    // At 0.01 % no more than a few of 180 true ones.
    EXPECT_GE(f.counts.accepted, 175) << seed;
  }
}

TEST(MissionGraph, FalseLoopsAreKeptOut) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    RoundsOptions o;
    o.seed = seed;
    const Flown f = fly(makeRounds(o), 0.3, seed);
    EXPECT_GT(f.false_offered, 30) << seed;
    EXPECT_EQ(f.false_accepted, 0) << seed;
    EXPECT_LT(f.smoothed, 0.15) << seed;
  }
}

TEST(MissionGraph, TheSameInputTheSameBytes) {
  RoundsOptions o;
  o.rounds = 3;
  const Flown a = fly(makeRounds(o), 0.3, 5), b = fly(makeRounds(o), 0.3, 5);
  ASSERT_EQ(a.path.size(), b.path.size());
  for (std::size_t i = 0; i < a.path.size(); ++i) {
    EXPECT_EQ(a.path[i].T_W_B.p, b.path[i].T_W_B.p);
    EXPECT_EQ(a.path[i].T_W_B.q.coeffs(), b.path[i].T_W_B.q.coeffs());
  }
}

TEST(MissionGraph, WithoutLoopsThePathStaysAsItIs) {
  RoundsOptions o;
  o.rounds = 1;
  const Rounds r = makeRounds(o);
  MissionGraph graph = graphOf(r);
  graph.solve();
  const std::vector<StampedPose> path = graph.path();
  ASSERT_EQ(path.size(), r.path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_LT((path[i].T_W_B.p - r.path[i].T_W_B.p).norm(), 1e-9);
  }
  EXPECT_LT(graph.correction().t_m.norm(), 1e-9);
  EXPECT_TRUE(graph.joined());
}

/// Where ranges hold the path, loops are of little use, and do no harm.
TEST(MissionGraph, WithAnchorsLoopsCorrectLittle) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    RoundsOptions o;
    o.seed = seed;
    o.held_sigma_m = 0.05;
    const Flown f = fly(makeRounds(o), 0.3, seed);
    EXPECT_LE(f.smoothed, f.odometry) << seed;
    EXPECT_LE(f.causal, 1.05 * f.odometry) << seed;
    EXPECT_EQ(f.false_accepted, 0) << seed;
  }
}

TEST(MissionGraph, RelativeCovarianceTellsTheTruth) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    RoundsOptions o;
    o.seed = seed;
    o.rounds = 1;
    const Rounds r = makeRounds(o);
    const MissionGraph graph = graphOf(r);
    const auto known = graph.relative(11, 101);
    ASSERT_TRUE(known);
    Random random(1);
    const Loop truth = trueLoop(r, 10, 100, &random, 0, 0);
    const Vec3 motion = r.path[10].T_W_B.R() * truth.T_older_newer.p;
    const double turn = nearestYaw(r.path[10].T_W_B.R() * truth.T_older_newer.R() *
                                   r.path[100].T_W_B.R().transpose());
    Eigen::Vector4d d;
    d << motion - known->motion_W, turn - known->turn_rad;
    sum += d.dot(known->covariance.inverse() * d);
    ++count;
  }
  EXPECT_NEAR(sum / count, 4, 1.6);  // 3 sigma of the mean of 30
}

/// The odometry is worse than it says: loops contradict it, but agree with one another.
TEST(MissionGraph, AgainstThePathOpinionsFromElsewhereAreNeeded) {
  RoundsOptions o;
  o.rounds = 2;
  const Rounds r = makeRounds(o);
  MissionGraph graph = graphOf(r);
  Random random(2);
  const auto raised = [&](int older, double by_m) {
    Loop loop = trueLoop(r, older, older + 120, &random);
    const auto k = static_cast<std::size_t>(older);
    loop.T_older_newer.p += r.path[k].T_W_B.q.conjugate() * Vec3(0, 0, by_m);
    return loop;
  };
  EXPECT_EQ(graph.offer(raised(10, 0.6)), LoopState::waiting);
  EXPECT_EQ(graph.offer(raised(11, 0.6)), LoopState::waiting);   // half a metre on
  EXPECT_EQ(graph.offer(raised(14, 0.6)), LoopState::waiting);   // two opinions, not three
  EXPECT_EQ(graph.offer(raised(50, -0.6)), LoopState::waiting);  // says something else
  EXPECT_EQ(graph.offer(raised(20, 0.6)), LoopState::accepted);
  EXPECT_GE(graph.counts().accepted, 3);
  EXPECT_EQ(graph.loops()[3].state, LoopState::waiting);
  EXPECT_EQ(graph.offer(raised(30, 3)), LoopState::refused);
}

TEST(MissionGraph, AnAcceptedLoopIsTakenBack) {
  // Drift that makes nearly everything possible: the first loop is false and passes.
  RoundsOptions o;
  o.rounds = 4;
  o.sigma_rad = 0.01;
  o.sigma_m = 0.03;
  const Rounds r = makeRounds(o);
  MissionGraph graph({});
  Random random(4);
  for (std::size_t i = 0; i < 260; ++i) graph.add(r.path[i]);
  Loop lie = trueLoop(r, 10, 250, &random);
  lie.T_older_newer.p.y() += 1.2;
  ASSERT_EQ(graph.offer(lie), LoopState::accepted);
  graph.solve();
  int offered = 0;
  for (std::size_t i = 260; i < r.path.size(); ++i) {
    graph.add(r.path[i]);
    if (i % 4 != 0) continue;
    const int newer = static_cast<int>(i);
    ++offered;
    graph.offer(trueLoop(r, newer - 240, newer, &random));
    if (graph.solveDue()) graph.solve();
  }
  graph.solve();
  EXPECT_EQ(graph.loops()[0].state, LoopState::taken_back);
  EXPECT_EQ(graph.counts().taken_back, 1);
  EXPECT_GE(graph.counts().accepted, offered * 9 / 10);
}

TEST(MissionGraph, SegmentsAreJoinedByTwoThatAgree) {
  RoundsOptions o;
  o.rounds = 2;
  Rounds r = makeRounds(o);
  for (std::size_t i = 120; i < r.path.size(); ++i) {
    // Lost for a while: the estimator goes on elsewhere, turned.
    r.path[i].segment = 1;
    r.path[i].segment_since = r.path[119].t + 100000000;
    r.path[i].T_W_B = Pose(Quat(rotZ(0.5)), Vec3(3, -2, 0.5)) * r.path[i].T_W_B;
  }
  MissionGraph graph({});
  Random random(2);
  for (std::size_t i = 0; i < 131; ++i) graph.add(r.path[i]);
  EXPECT_FALSE(graph.joined());
  EXPECT_FALSE(graph.relative(5, 125));
  Loop lie = trueLoop(r, 3, 123, &random);
  lie.T_older_newer.p.x() += 1;
  EXPECT_EQ(graph.offer(lie), LoopState::waiting);
  EXPECT_EQ(graph.offer(trueLoop(r, 5, 125, &random)), LoopState::waiting);
  EXPECT_FALSE(graph.joined());
  EXPECT_EQ(graph.offer(trueLoop(r, 7, 127, &random)), LoopState::accepted);
  EXPECT_TRUE(graph.joined());
  EXPECT_TRUE(graph.solveDue());
  graph.solve();
  EXPECT_EQ(graph.loops()[0].state, LoopState::waiting);
  EXPECT_LT((graph.path()[130].T_W_B.p - r.truth[130].p).norm(), 0.6);
  EXPECT_LT((graph.poseOf(131)->p - graph.path()[130].T_W_B.p).norm(), 1e-12);
  // What the estimator had of the new segment before its first keyframe here belongs to it.
  const LevelTransform before = graph.correctionAt(r.path[119].t + 50000000);
  const LevelTransform after = graph.correctionAt(r.path[119].t + 150000000);
  EXPECT_EQ(before.t_m, graph.correctionAt(r.path[119].t).t_m);
  EXPECT_EQ(after.t_m, graph.correctionAt(r.path[120].t).t_m);
  EXPECT_GT((after.t_m - before.t_m).norm(), 1);
}

/// The run's world is turned and far from the map's.
TEST(MissionGraph, ARunIsFoundInAMap) {
  RoundsOptions o;
  o.rounds = 1;
  const Rounds map = makeRounds(o);
  o.first_id = 1000;
  o.seed = 9;
  Rounds run = makeRounds(o);
  const Pose elsewhere(Quat(rotZ(2.9)), Vec3(300, 20, -5));
  for (PathNode& n : run.path) n.T_W_B = elsewhere * n.T_W_B;
  MissionGraph graph({});
  for (std::size_t i = 0; i < map.path.size(); ++i) {
    graph.addFixed(map.path[i].id, map.path[i].t, map.truth[i]);
  }
  Random random(2);
  const auto between = [&](int older, int newer) {
    Loop loop = trueLoop(map, older, newer, &random);
    loop.newer = run.path[static_cast<std::size_t>(newer)].id;
    return loop;
  };
  for (std::size_t i = 0; i < 100; ++i) graph.add(run.path[i]);
  EXPECT_EQ(graph.offer(between(50, 50)), LoopState::waiting);
  EXPECT_EQ(graph.offer(between(53, 52)), LoopState::accepted);
  graph.solve();
  EXPECT_TRUE(graph.joined());
  const std::vector<StampedPose> path = graph.path();
  ASSERT_EQ(path.size(), 100u);
  EXPECT_LT((path[52].T_W_B.p - map.truth[52].p).norm(), 0.1);
  EXPECT_LT((path[99].T_W_B.p - map.truth[99].p).norm(), 0.6);
  // Map keyframes stay, and what comes next continues in the map.
  EXPECT_EQ(graph.poseOf(map.path[7].id)->p, map.truth[7].p);
  graph.add(run.path[100]);
  EXPECT_LT((graph.path().back().T_W_B.p - map.truth[100].p).norm(), 0.6);
  // Later loops say better where that is, however far W is turned against the map.
  for (int k = 60; k <= 100; k += 5) graph.offer(between(k, k));
  graph.solve();
  EXPECT_LT((graph.path().back().T_W_B.p - map.truth[100].p).norm(), 0.05);
}

TEST(MissionGraph, CorrectionsBetweenKeyframes) {
  RoundsOptions o;
  o.rounds = 2;
  const Rounds r = makeRounds(o);
  MissionGraph graph = graphOf(r);
  Random random(2);
  graph.offer(trueLoop(r, 10, 130, &random));
  graph.offer(trueLoop(r, 90, 210, &random));
  graph.solve();
  for (const std::size_t i : {0u, 60u, 131u, 239u}) {
    const Pose T = graph.correctionAt(r.path[i].t).pose() * r.path[i].T_W_B;
    EXPECT_LT((T.p - graph.path()[i].T_W_B.p).norm(), 1e-9) << i;
  }
  const TimeNs between = (r.path[60].t + r.path[61].t) / 2;
  const Vec3 p = 0.5 * (r.path[60].T_W_B.p + r.path[61].T_W_B.p);
  const Vec3 expected = 0.5 * (graph.path()[60].T_W_B.p + graph.path()[61].T_W_B.p);
  EXPECT_LT((graph.correctionAt(between) * p - expected).norm(), 1e-9);
}

TEST(MissionGraph, WhatCannotBeIsRefused) {
  RoundsOptions o;
  o.rounds = 2;
  const Rounds r = makeRounds(o);
  MissionGraph graph = graphOf(r);
  Random random(2);
  const Loop good = trueLoop(r, 10, 130, &random);
  const auto refuses = [&](const Loop& loop) { return graph.offer(loop) == LoopState::refused; };
  Loop loop = good;
  loop.older = 9999;
  EXPECT_TRUE(refuses(loop));
  loop = good;
  std::swap(loop.older, loop.newer);
  EXPECT_TRUE(refuses(loop));
  loop = good;
  loop.newer = loop.older;
  EXPECT_TRUE(refuses(loop));
  loop = good;
  loop.T_older_newer.p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refuses(loop));
  loop = good;
  loop.covariance(2, 2) = -1;
  EXPECT_TRUE(refuses(loop));
  loop = good;
  loop.T_older_newer.q = Quat(0, 0, 0, 0);
  EXPECT_TRUE(refuses(loop));
  loop = good;
  loop.T_older_newer.q = loop.T_older_newer.q * expQuat(Vec3(0.1, 0, 0));  // against gravity
  EXPECT_TRUE(refuses(loop));
  loop = good;
  loop.T_older_newer.p.x() += 30;
  EXPECT_TRUE(refuses(loop));
  EXPECT_EQ(graph.offer(good), LoopState::accepted);
  EXPECT_EQ(graph.counts().refused, 8);
  PathNode again = r.path.back();
  EXPECT_THROW(graph.add(again), std::invalid_argument);
  again.id += 1;
  EXPECT_THROW(graph.add(again), std::invalid_argument);  // the same stamp
  GraphOptions bad;
  bad.gate = 0;
  EXPECT_THROW(MissionGraph{bad}, std::invalid_argument);
  MissionGraph empty({});
  empty.solve();
  EXPECT_TRUE(empty.joined());
  EXPECT_EQ(empty.offer(good), LoopState::refused);
}

/// The covariance of the newest keyframe is that of its error, in metres and radians: normalised
/// squared errors of four degrees of freedom over flights that differ.
TEST(MissionGraph, TheCovarianceAfterLoopsIsHonest) {
  GraphOptions o;
  o.loop_sigma_m = 1e-4;  // the loops here have no errors beside those they know of
  o.loop_sigma_rad = 1e-5;
  double sum = 0;
  int asked = 0;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    RoundsOptions flight;
    flight.rounds = 3;
    flight.seed = seed;
    const Rounds r = makeRounds(flight);
    MissionGraph graph(o);
    Random random(seed + 100);
    for (std::size_t i = 0; i < r.path.size(); ++i) {
      graph.add(r.path[i]);
      const int k = static_cast<int>(i);
      if (k < r.per_round) {
        EXPECT_FALSE(graph.covariance());
      }
      if (k >= r.per_round && k % 10 == 0) graph.offer(trueLoop(r, k - r.per_round, k, &random));
      if (k >= r.per_round && k % 40 == 0) graph.solve();
      if (k < r.per_round || k % 40 != 9) continue;  // 4.5 m after the last loop
      const auto P = graph.covariance();
      if (!P) continue;
      const LevelTransform T_M_W = graph.correction();
      Eigen::Vector4d e;
      e << T_M_W * r.path[i].T_W_B.p - r.truth[i].p,
          nearestYaw((T_M_W.pose() * r.path[i].T_W_B).R() * r.truth[i].R().transpose());
      sum += e.dot(P->ldlt().solve(e)) / 4;
      ++asked;
    }
  }
  ASSERT_GT(asked, 40);
  EXPECT_GT(sum / asked, 0.7);
  EXPECT_LT(sum / asked, 1.4);
}

}  // namespace
}  // namespace vir::mission
