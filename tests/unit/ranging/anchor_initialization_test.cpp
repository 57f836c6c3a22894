#include "vir/ranging/anchor_initialization.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <stdexcept>

#include "made_ranges.h"

namespace {

using vir::Mat3;
using vir::Vec3;
using vir::ranging::AnchorGeometry;
using vir::ranging::AnchorInitialization;
using vir::ranging::AnchorInitOptions;
using vir::ranging::AnchorPrior;
using vir::ranging::AntennaRange;
using vir::test::Flight;
using vir::test::fly;
using vir::test::plainOptions;

bool begins(const std::string& text, const std::string& with) { return text.rfind(with, 0) == 0; }

bool finite(const AnchorInitialization& r) {
  for (const auto& s : r.solutions) {
    if (!s.p_W.allFinite() || !std::isfinite(s.bias_m) || !s.covariance.allFinite()) return false;
    if (Eigen::LLT<Eigen::Matrix4d>(s.covariance).info() != Eigen::Success) return false;
  }
  return true;
}

const Mat3 kTilt = vir::expSO3(Vec3(0.5, -0.4, 0.7));

TEST(AnchorInitialization, ExactWithoutNoise) {
  for (const Vec3& anchor : {Vec3(3, 1, 2), Vec3(0.3, 0.1, 0.2), Vec3(-40, 90, 5)}) {
    Flight f;
    f.anchor = anchor;
    f.noise = false;
    f.turn = kTilt;
    if (anchor.norm() > 10) f.amplitude = Vec3(20, 20, 5);
    const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions());
    ASSERT_EQ(r.geometry, AnchorGeometry::good) << anchor.transpose() << " " << r.advice;
    ASSERT_EQ(r.solutions.size(), 1u);
    EXPECT_LT((r.solutions[0].p_W - anchor).norm(), 1e-6) << anchor.transpose();
    EXPECT_NEAR(r.solutions[0].bias_m, 0, 1e-6);
    EXPECT_EQ(r.outliers, 0);
    EXPECT_TRUE(finite(r));
  }
}

TEST(AnchorInitialization, ABiasIsFound) {
  Flight f;
  f.amplitude = Vec3(4, 4, 2);
  f.bias = 0.08;
  const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions());
  ASSERT_EQ(r.geometry, AnchorGeometry::good);
  EXPECT_NEAR(r.solutions[0].bias_m, 0.08, 4 * std::sqrt(r.solutions[0].covariance(3, 3)));
  EXPECT_LT((r.solutions[0].p_W - f.anchor).norm(), 0.1);
}

TEST(AnchorInitialization, PlanarMotionGivesMirrorImages) {
  // The plane may lie anyhow.
  for (const Mat3& turn : {Mat3(Mat3::Identity()), kTilt}) {
    Flight f;
    f.amplitude.z() = 0;
    f.turn = turn;
    f.anchor = turn * Vec3(3, 1, 1.5);
    const Vec3 image = turn * Vec3(3, 1, -1.5);
    const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions());
    ASSERT_EQ(r.geometry, AnchorGeometry::mirror) << r.advice;
    ASSERT_EQ(r.solutions.size(), 2u);
    const bool first = (r.solutions[0].p_W - f.anchor).norm() < 1;
    EXPECT_LT((r.solutions[first ? 0 : 1].p_W - f.anchor).norm(), 0.25);
    EXPECT_LT((r.solutions[first ? 1 : 0].p_W - image).norm(), 0.25);
    EXPECT_LT(r.solutions[0].cost, r.solutions[1].cost + 1e-9);
  }
  Flight level;
  level.amplitude.z() = 0;
  EXPECT_TRUE(
      begins(vir::ranging::initializeAnchor(fly(level), plainOptions()).advice, "change height"));
  Flight upright;  // a vertical plane
  upright.amplitude = Vec3(2, 0, 2);
  upright.anchor = Vec3(1, 3, 1);
  const auto r = vir::ranging::initializeAnchor(fly(upright), plainOptions());
  EXPECT_EQ(r.geometry, AnchorGeometry::mirror);
  EXPECT_TRUE(begins(r.advice, "move sideways")) << r.advice;
}

TEST(AnchorInitialization, HeightChangeRejectsTheMirrorImage) {
  Flight f;
  f.amplitude.z() = 0.4;
  for (int seed = 1; seed <= 50; ++seed) {
    const auto r = vir::ranging::initializeAnchor(fly(f, seed), plainOptions());
    ASSERT_EQ(r.geometry, AnchorGeometry::good) << r.advice;
    EXPECT_LT((r.solutions[0].p_W - f.anchor).norm(), 0.3) << seed;
  }
}

TEST(AnchorInitialization, PlanarMotionLevelWithTheAnchorIsUsable) {
  Flight f;
  f.amplitude.z() = 0;
  f.anchor = Vec3(3, 1, 0.1);
  const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions());
  ASSERT_EQ(r.geometry, AnchorGeometry::good) << r.advice;
  const auto& s = r.solutions[0];
  EXPECT_LT((s.p_W - f.anchor).head<2>().norm(), 0.1);
  EXPECT_LT(std::sqrt(s.covariance(0, 0)), 0.05);
  // The height is what it is: the true one is covered, and the sigma many times the horizontal.
  EXPECT_GT(std::sqrt(s.covariance(2, 2)), 0.1);
  EXPECT_LT(std::sqrt(s.covariance(2, 2)), 0.6);
}

TEST(AnchorInitialization, FromAFloorAFarAnchorIsFoundWithoutItsHeight) {
  Flight f;
  f.amplitude = Vec3(12, 12, 0);
  f.anchor = Vec3(40, 15, 1.5);
  f.sigma = 0.3;
  auto options = plainOptions();
  options.floor_sigma_m = 0;
  const auto nowhere = vir::ranging::initializeAnchor(fly(f), options);
  EXPECT_EQ(nowhere.geometry, AnchorGeometry::poor) << nowhere.advice;
  EXPECT_FALSE(nowhere.floor);
  options.floor_sigma_m = 5;
  const auto found = vir::ranging::initializeAnchor(fly(f), options);
  ASSERT_TRUE(found.geometry == AnchorGeometry::good || found.geometry == AnchorGeometry::mirror)
      << found.advice;
  EXPECT_LT((found.solutions[0].p_W - f.anchor).head<2>().norm(), 0.6);
  EXPECT_LT(std::abs(found.solutions[0].p_W.z() - f.anchor.z()),
            3 * std::sqrt(found.solutions[0].covariance(2, 2)));
  ASSERT_TRUE(found.floor);
  EXPECT_NEAR(found.floor->p_W.z(), 0, 1e-9);
  EXPECT_NEAR(found.floor->covariance(2, 2), 25, 1e-4);
  // A flight is none, nor is a vertical plane.
  f.amplitude.z() = 3;
  EXPECT_FALSE(vir::ranging::initializeAnchor(fly(f), options).floor);
  f.amplitude = Vec3(12, 0, 12);
  EXPECT_FALSE(vir::ranging::initializeAnchor(fly(f), options).floor);
}

TEST(AnchorInitialization, AStraightLineIsRecognised) {
  for (const double side : {0.5, 3.0}) {
    Flight f;
    f.amplitude = Vec3(3, 0.003, 0.003);
    f.anchor = Vec3(1, side, 1);
    const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions());
    EXPECT_EQ(r.geometry, AnchorGeometry::straight_line) << side << r.advice;
    EXPECT_TRUE(begins(r.advice, "move sideways")) << r.advice;
    EXPECT_TRUE(finite(r));
  }
}

TEST(AnchorInitialization, AShortPathForTheDistance) {
  Flight f;
  f.anchor = Vec3(60, 50, 4);
  f.amplitude = Vec3(0.5, 0.5, 0.3);
  const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions());
  EXPECT_EQ(r.geometry, AnchorGeometry::too_short);
  EXPECT_TRUE(begins(r.advice, "move further")) << r.advice;
  EXPECT_TRUE(finite(r));
}

TEST(AnchorInitialization, WithoutLineOfSight) {
  for (const double share : {0.1, 0.3}) {
    for (const double height : {0.0, 1.0}) {
      double worst = 0;
      for (int seed = 1; seed <= 50; ++seed) {
        Flight f;
        f.nlos = share;
        f.amplitude.z() = height;
        const auto r = vir::ranging::initializeAnchor(fly(f, seed), plainOptions());
        ASSERT_EQ(r.geometry, height > 0 ? AnchorGeometry::good : AnchorGeometry::mirror);
        double best = 1e9;
        for (const auto& s : r.solutions) best = std::min(best, (s.p_W - f.anchor).norm());
        worst = std::max(worst, best);
        EXPECT_NEAR(r.outliers, share * f.ranges, 0.1 * f.ranges);
      }
      EXPECT_LT(worst, 0.2) << share << " " << height;
    }
  }
}

TEST(AnchorInitialization, AnAnchorThatMovesIsInconsistent) {
  auto ranges = fly(Flight());
  Flight other;
  other.anchor = Vec3(-3, 2, 0);
  const auto later = fly(other, 2);
  for (std::size_t i = 150; i < 300; ++i) ranges[i] = later[i];
  EXPECT_EQ(vir::ranging::initializeAnchor(ranges, plainOptions()).geometry,
            AnchorGeometry::inconsistent);
}

TEST(AnchorInitialization, APriorDecidesBetweenMirrorImages) {
  Flight f;
  f.amplitude.z() = 0;
  const AnchorPrior prior{f.anchor + Vec3(0.3, -0.2, 0.3), 0.25 * Mat3::Identity()};
  const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions(), prior);
  ASSERT_EQ(r.geometry, AnchorGeometry::good) << r.advice;
  EXPECT_LT((r.solutions[0].p_W - f.anchor).norm(), 0.2);
}

TEST(AnchorInitialization, APriorIsEnoughAfterOneRange) {
  Flight f;
  f.ranges = 1;
  const AnchorPrior prior{f.anchor, 0.01 * Mat3::Identity()};
  const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions(), prior);
  ASSERT_EQ(r.geometry, AnchorGeometry::good) << r.advice;
  EXPECT_LT((r.solutions[0].p_W - f.anchor).norm(), 0.2);
  EXPECT_LT(r.solutions[0].covariance.topLeftCorner(3, 3).trace(), 0.0301);
}

TEST(AnchorInitialization, APriorThatIsWrongIsReported) {
  const Flight f;
  const AnchorPrior prior{f.anchor + Vec3(3, 0, 0), 0.01 * Mat3::Identity()};
  const auto r = vir::ranging::initializeAnchor(fly(f), plainOptions(), prior);
  EXPECT_EQ(r.geometry, AnchorGeometry::inconsistent) << r.solutions[0].p_W.transpose();
  Mat3 bad = Mat3::Identity();
  bad(0, 0) = -1;
  EXPECT_THROW(
      vir::ranging::initializeAnchor(fly(f), plainOptions(), AnchorPrior{Vec3::Zero(), bad}),
      std::invalid_argument);
}

TEST(AnchorInitialization, DriftOfThePathIsInTheCovariance) {
  AnchorInitOptions drifting;
  drifting.drift_ratio = 0.02;
  const auto with = vir::ranging::initializeAnchor(fly(Flight()), drifting);
  const auto without = vir::ranging::initializeAnchor(fly(Flight()), plainOptions());
  EXPECT_GT(with.solutions[0].covariance(0, 0), 2 * without.solutions[0].covariance(0, 0));
}

TEST(AnchorInitialization, DegenerateInputIsFiniteAndExplained) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Flight f;
  std::vector<std::vector<AntennaRange>> cases(7);
  cases[1] = {fly(f)[0]};
  cases[2].assign(100, fly(f)[0]);
  cases[3] = fly(f);
  for (auto& r : cases[3]) r.range_m = nan;
  cases[4] = fly(f);
  for (auto& r : cases[4]) r.sigma_m = 0;
  cases[5] = fly(f);  // constant ranges on a moving path
  for (auto& r : cases[5]) r.range_m = 5;
  cases[6] = fly(f);  // no distance at all
  for (auto& r : cases[6]) r.range_m = 1e-12;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto r = vir::ranging::initializeAnchor(cases[i], plainOptions());
    EXPECT_NE(r.geometry, AnchorGeometry::good) << i;
    EXPECT_FALSE(r.advice.empty()) << i;
    EXPECT_TRUE(finite(r)) << i;
    const AnchorPrior prior{f.anchor, Mat3::Identity()};
    EXPECT_TRUE(finite(vir::ranging::initializeAnchor(cases[i], plainOptions(), prior))) << i;
  }
  auto mixed = fly(f);
  mixed[7].range_m = nan;
  mixed[8].p_W.x() = inf;
  mixed[9].range_m = -3;
  mixed[10].sigma_m = -1;
  const auto r = vir::ranging::initializeAnchor(mixed, plainOptions());
  EXPECT_EQ(r.geometry, AnchorGeometry::good);
  EXPECT_EQ(r.ignored, 4);
}

TEST(AnchorInitialization, ThePathMayPassThroughTheAnchor) {
  Flight f;
  f.noise = false;
  f.anchor = fly(f)[150].p_W;
  const auto ranges = fly(f);
  const auto r = vir::ranging::initializeAnchor(ranges, plainOptions());
  EXPECT_EQ(r.geometry, AnchorGeometry::good) << r.advice;
  EXPECT_LT((r.solutions[0].p_W - f.anchor).norm(), 1e-3);
}

TEST(AnchorInitialization, TheSameInputGivesTheSameBits) {
  Flight f;
  f.nlos = 0.3;
  const auto a = vir::ranging::initializeAnchor(fly(f), plainOptions());
  const auto b = vir::ranging::initializeAnchor(fly(f), plainOptions());
  EXPECT_EQ(a.solutions[0].p_W, b.solutions[0].p_W);
  EXPECT_EQ(a.solutions[0].covariance, b.solutions[0].covariance);
}

}  // namespace
