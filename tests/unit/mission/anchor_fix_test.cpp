/// Where a run lies in a map, by anchors that both know.
#include "anchor_fix.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <vector>

#include "vir/core/random.h"

namespace vir::mission {
namespace {

Anchor anchorAt(std::uint64_t id, const Vec3& p, double sigma = 0.05) {
  Anchor a;
  a.id = id;
  a.has_position = true;
  a.p_W = p;
  a.covariance = sigma * sigma * Mat3::Identity();
  a.state = AnchorState::estimated;
  return a;
}

const LevelTransform kTruth{2.1, Vec3(12, -7, 1.5)};

/// Of the map's anchors with ids from 1 on, the first `n` as the run has them.
std::vector<Anchor> asTheRunHas(const std::vector<Anchor>& in_M, std::size_t n, Random* random) {
  std::vector<Anchor> out;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 noise(random->normal(), random->normal(), random->normal());
    out.push_back(anchorAt(in_M[i].id, kTruth.inverse() * in_M[i].p_W + 0.05 * noise));
  }
  return out;
}

std::vector<Anchor> ofTheMap() {
  return {anchorAt(1, Vec3(0, 0, 2)), anchorAt(2, Vec3(9, 1, 2.5)), anchorAt(3, Vec3(5, 8, 3)),
          anchorAt(4, Vec3(0, 7, 1))};
}

TEST(AnchorFix, TwoAnchorsSayWhereTheRunIs) {
  Random random(4);
  const std::vector<Anchor> map = ofTheMap();
  for (const std::size_t n : {2u, 3u, 4u}) {
    for (int i = 0; i < 50; ++i) {
      const auto fix = fixByAnchors(map, asTheRunHas(map, n, &random));
      ASSERT_TRUE(fix) << n;
      Eigen::Vector4d e;
      e << fix->T.t_m - kTruth.t_m, std::remainder(fix->T.yaw_rad - kTruth.yaw_rad, 2 * M_PI);
      EXPECT_LT(e.dot(fix->P.ldlt().solve(e)), 23) << n;  // 99.99 % of four degrees of freedom
      EXPECT_LT(std::abs(e(3)), 0.1) << n;
    }
  }
}

TEST(AnchorFix, SaysNothingWhereItCannot) {
  Random random(5);
  const std::vector<Anchor> map = ofTheMap();
  EXPECT_FALSE(fixByAnchors(map, {}));
  EXPECT_FALSE(fixByAnchors({}, map));
  EXPECT_FALSE(fixByAnchors(map, asTheRunHas(map, 1, &random)));
  std::vector<Anchor> run = asTheRunHas(map, 2, &random);
  run[1].id = 77;  // none of the map's
  EXPECT_FALSE(fixByAnchors(map, run));
  run = asTheRunHas(map, 2, &random);
  run[1].state = AnchorState::mirror_open;
  EXPECT_FALSE(fixByAnchors(map, run));
  run = asTheRunHas(map, 4, &random);
  run[2].p_W += Vec3(2, 0, 0);  // has been moved
  EXPECT_FALSE(fixByAnchors(map, run));
  // One above the other: no heading.
  const std::vector<Anchor> mast{anchorAt(1, Vec3(1, 1, 0)), anchorAt(2, Vec3(1, 1, 4))};
  EXPECT_FALSE(fixByAnchors(mast, mast));
}

TEST(AnchorFix, ASingleAnchorRefusesWhatCannotBe) {
  Random random(6);
  const std::vector<Anchor> map = ofTheMap(), run = asTheRunHas(map, 1, &random);
  LevelGuess right;
  right.T = kTruth;
  const AnchorFit fits = anchorFit(right, map, run);
  EXPECT_EQ(fits.dof, 3);
  EXPECT_LT(fits.chi2, 16.3);
  LevelGuess wrong = right;
  wrong.T.t_m += Vec3(3.2, 0, 0);  // the bay beside
  EXPECT_GT(anchorFit(wrong, map, run).chi2, 100);
  EXPECT_EQ(anchorFit(right, map, {}).dof, 0);
}

}  // namespace
}  // namespace vir::mission
