#include "motion_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "synthetic_view.h"

namespace vir::vision {
namespace {

/// Points 2 to 8 m away seen before and after a motion, with noise of 0.1 px.
struct Scene {
  std::shared_ptr<const camera::CameraModel> camera = camera::makeCamera(test::smallCamera());
  std::vector<BearingPair> pairs;

  Scene(int n, const Mat3& R_C0_C1, const Vec3& p_C0_C1, unsigned seed = 5) {
    std::mt19937 random(seed);  // its raw numbers are the same everywhere
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
    while (static_cast<int>(pairs.size()) < n) {
      const Vec2 px0(10 + 356 * uniform(), 10 + 220 * uniform());
      BearingPair p;
      if (!camera->unproject(px0, &p.b0)) continue;
      const Vec3 point = (2.0 + 6.0 * uniform()) * p.b0;
      Vec2 px1;
      if (!camera->project(R_C0_C1.transpose() * (point - p_C0_C1), &px1)) continue;
      px1 += 0.2 * Vec2(uniform() + uniform() - 1.0, uniform() + uniform() - 1.0);
      if (set(px1, &p)) pairs.push_back(p);
    }
  }
  bool set(const Vec2& px1, BearingPair* p) const {
    Vec2 again;
    return camera->unproject(px1, &p->b1) && camera->project(p->b1, &again, &p->J1);
  }
  /// Moves the current pixel of pair `i`.
  void shift(std::size_t i, const Vec2& by) {
    Vec2 px;
    camera->project(pairs[i].b1, &px);
    ASSERT_TRUE(set(px + by, &pairs[i]));
  }
};

int inliers(const MotionVerdict& v) {
  return static_cast<int>(std::count(v.inlier.begin(), v.inlier.end(), 1));
}

const Vec3 kTurn(0.02, -0.03, 0.05);
const Vec3 kMove(0.12, -0.05, 0.06);

TEST(MotionFilter, KeepsTheGoodAndFindsTheDirection) {
  const Scene scene(100, expSO3(kTurn), kMove);
  const MotionVerdict v = filterByMotion(scene.pairs, expSO3(kTurn), 0.004, 1.0);
  EXPECT_EQ(inliers(v), 100);
  EXPECT_GT(v.direction.dot(kMove.normalized()), std::cos(0.03));
}

TEST(MotionFilter, RejectsAThirdOfWrongTracks) {
  Scene scene(99, expSO3(kTurn), kMove);
  std::mt19937 random(11);
  // Across the epipolar lines, which run mainly sideways here.
  for (std::size_t i = 0; i < 33; ++i) {
    scene.shift(i, Vec2(0.5, random() % 2 == 0 ? 5.0 : -6.0));
  }
  const MotionVerdict v = filterByMotion(scene.pairs, expSO3(kTurn), 0.004, 1.0);
  int wrong_kept = 0, good_lost = 0;
  for (std::size_t i = 0; i < 99; ++i) {
    if (i < 33 && v.inlier[i]) ++wrong_kept;
    if (i >= 33 && !v.inlier[i]) ++good_lost;
  }
  EXPECT_LE(wrong_kept, 3);
  EXPECT_EQ(good_lost, 0);
}

TEST(MotionFilter, FindsTheGyroErrorItself) {
  const Vec3 error(0.001, -0.003, 0.0025);  // 0.08 rad/s over 50 ms
  const Scene scene(100, expSO3(kTurn), kMove);
  const Mat3 given = expSO3(kTurn) * expSO3(error);
  const MotionVerdict v = filterByMotion(scene.pairs, given, 0.004, 1.0);
  EXPECT_EQ(inliers(v), 100);
  EXPECT_LT((v.rotation_correction + error).norm(), 0.0015);
}

TEST(MotionFilter, RejectsPointsBehindTheCamera) {
  Scene scene(60, expSO3(kTurn), kMove);
  // Twice the parallax backwards along the line: on it, but in the wrong direction.
  for (std::size_t i = 0; i < 6; ++i) {
    const Vec2 parallax =
        scene.pairs[i].J1 * (scene.pairs[i].b1 - expSO3(kTurn).transpose() * scene.pairs[i].b0);
    scene.shift(i, -2.0 * parallax);
  }
  const MotionVerdict v = filterByMotion(scene.pairs, expSO3(kTurn), 0.004, 1.0);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_FALSE(v.inlier[i]);
  EXPECT_EQ(inliers(v), 54);
}

TEST(MotionFilter, PureRotationAndStandstill) {
  for (const Vec3& turn : {Vec3(0.02, -0.03, 0.05), Vec3(0, 0, 0)}) {
    Scene scene(80, expSO3(turn), Vec3::Zero());
    for (std::size_t i = 0; i < 5; ++i) scene.shift(i, Vec2(2.0, -2.0));
    const MotionVerdict v =
        filterByMotion(scene.pairs, expSO3(turn) * expSO3(Vec3(0.003, 0.002, -0.002)), 0.004, 1.0);
    EXPECT_EQ(inliers(v), 75);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_FALSE(v.inlier[i]);
    EXPECT_EQ(v.direction, Vec3::Zero());
  }
}

TEST(MotionFilter, FewTracks) {
  for (int n = 0; n < 9; ++n) {
    const Scene scene(n, expSO3(kTurn), kMove);
    const MotionVerdict v = filterByMotion(scene.pairs, expSO3(kTurn), 0.004, 1.0);
    EXPECT_EQ(static_cast<int>(v.inlier.size()), n);
    EXPECT_EQ(inliers(v), n);
    EXPECT_TRUE(v.rotation_correction.allFinite() && v.direction.allFinite());
  }
}

TEST(MotionFilter, IdenticalPairsAreNotDegenerate) {
  Scene scene(1, expSO3(kTurn), kMove);
  const std::vector<BearingPair> same(20, scene.pairs[0]);
  const MotionVerdict v = filterByMotion(same, expSO3(kTurn), 0.004, 1.0);
  EXPECT_TRUE(v.rotation_correction.allFinite() && v.direction.allFinite());
  EXPECT_EQ(inliers(v), 20);
}

}  // namespace
}  // namespace vir::vision
