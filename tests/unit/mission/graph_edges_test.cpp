#include "graph_edges.h"

#include <gtest/gtest.h>

#include "level_algebra.h"
#include "rounds.h"
#include "vir/core/random.h"

namespace vir::mission {
namespace {

using vir_test::makeRounds;
using vir_test::Rounds;
using vir_test::RoundsOptions;

TEST(GraphEdges, OdometryGrowsByItsOwnNoiseOnly) {
  RoundsOptions o;
  o.rounds = 1;
  const Rounds r = makeRounds(o);
  for (const std::size_t i : {1u, 20u, 119u}) {
    const StepNoise n = followedNoise(r.path[i - 1], r.path[i], {});
    // The noise of a step turns with the heading's error, which is a small part of it.
    EXPECT_NEAR(n.way[0], 0.5 * 1e-4, 2e-5) << i;
    EXPECT_NEAR(n.way[2], 0.5 * 1e-4, 1e-7) << i;
    EXPECT_NEAR(n.way[3], 0.5 * 4e-6, 1e-9) << i;
    EXPECT_EQ(n.tie.maxCoeff(), 0) << i;
  }
}

TEST(GraphEdges, OfUnknownAccuracyDriftIsAssumed) {
  RoundsOptions o;
  o.rounds = 1;
  o.knows_covariance = false;
  const Rounds r = makeRounds(o);
  const StepNoise n = followedNoise(r.path[4], r.path[5], {});
  EXPECT_NEAR(n.way[0], 0.02 * 0.02 * 0.5, 1e-5);
  EXPECT_EQ(n.tie.maxCoeff(), 0);
}

/// A chain of such steps has the variance that the estimator told, everywhere.
TEST(GraphEdges, TiesHoldWhatRangesHold) {
  RoundsOptions o;
  o.rounds = 1;
  o.held_sigma_m = 0.1;
  const Rounds r = makeRounds(o);
  double information = 0;  // of the position along x, forwards through the chain
  for (std::size_t i = 1; i < r.path.size(); ++i) {
    const StepNoise n = followedNoise(r.path[i - 1], r.path[i], {});
    ASSERT_GT(n.tie[0], 0);
    const double before = information > 0 ? 1 / information : 0.01;
    information = 1 / (before + n.way[0]) + 1 / n.tie[0];
  }
  // Filtered: between the half that a neighbourhood on both sides would leave, and the whole.
  EXPECT_GT(1 / information, 0.3 * 0.01);
  EXPECT_LT(1 / information, 1.25 * 0.01);
}

TEST(GraphEdges, WhatAnchorsJustHeldIsNearlyFree) {
  PathNode before, after;
  after.id = 1;
  after.t = 1;
  after.held = true;
  before.covariance.diagonal().setConstant(1.0);
  after.covariance.diagonal().setConstant(1e-4);
  const StepNoise n = followedNoise(before, after, {});
  EXPECT_NEAR(n.tie[0], 1e-4, 2e-5);
}

TEST(GraphEdges, ALoopInAxesOfTheEstimator) {
  RoundsOptions o;
  o.rounds = 2;
  o.sigma_m = o.sigma_rad = 0;
  const Rounds r = makeRounds(o);
  Random random(3);
  const Loop loop = vir_test::trueLoop(r, 7, 150, &random, 0, 0);
  Pose turned = r.path[150].T_W_B;
  turned.q = Quat(rotZ(-0.3)) * turned.q;
  const LevelLoop l = levelLoop(loop, r.path[7].T_W_B, turned, {});
  EXPECT_NEAR(l.turn_rad, 0.3, 1e-9);
  EXPECT_NEAR((l.motion_W - (r.truth[150].p - r.truth[7].p)).norm(), 0, 1e-9);
  EXPECT_NEAR(l.tilt_rad, 0, 1e-7);
  turned.q = expQuat(Vec3(0.2, 0, 0)) * turned.q;
  EXPECT_NEAR(levelLoop(loop, r.path[7].T_W_B, turned, {}).tilt_rad, 0.2, 1e-3);
}

/// Covariances of products and inverses, against differences.
TEST(LevelAlgebra, CovariancesByDifferences) {
  const LevelTransform A{0.7, Vec3(1, 2, 3)}, B{-1.2, Vec3(-4, 0.5, 1)};
  const auto moved = [](const LevelTransform& T, int k, double h) {
    LevelTransform out = T;
    if (k < 3) out.t_m[k] += h;
    if (k == 3) out.yaw_rad += h;
    return out;
  };
  const auto vector = [](const LevelTransform& T) {
    Eigen::Vector4d v;
    v << T.t_m, T.yaw_rad;
    return v;
  };
  const auto plain = [](const LevelTransform& T) {
    LevelGuess out;
    out.T = T;
    return out;
  };
  constexpr double h = 1e-6;
  for (int k = 0; k < 4; ++k) {
    LevelGuess one = plain(A), other = plain(B);
    one.P(k, k) = 1;
    const Eigen::Vector4d dA = (vector(moved(A, k, h) * B) - vector(moved(A, k, -h) * B)) / (2 * h);
    EXPECT_NEAR(((one * plain(B)).P - dA * dA.transpose()).norm(), 0, 1e-7) << k;
    const Eigen::Vector4d di =
        (vector(moved(A, k, h).inverse()) - vector(moved(A, k, -h).inverse())) / (2 * h);
    EXPECT_NEAR((inverse(one).P - di * di.transpose()).norm(), 0, 1e-7) << k;
    other.P(k, k) = 1;
    const Eigen::Vector4d dB = (vector(A * moved(B, k, h)) - vector(A * moved(B, k, -h))) / (2 * h);
    EXPECT_NEAR(((plain(A) * other).P - dB * dB.transpose()).norm(), 0, 1e-7) << k;
  }
}

TEST(GraphEdges, TransportTakesOneCovarianceToTheOther) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    Eigen::Matrix4d A, B;
    for (int k = 0; k < 16; ++k) {
      A(k) = random.normal();
      B(k) = 0.1 * random.normal();
    }
    A = (A * A.transpose()).eval();
    B = (B * B.transpose()).eval();
    const Eigen::Matrix4d S = transportOf(A, B);
    EXPECT_LT((S - S.transpose()).norm(), 1e-6 * S.norm());
    EXPECT_LT((S * A * S.transpose() - B).norm(), 1e-6 * B.norm());
  }
}

}  // namespace
}  // namespace vir::mission
