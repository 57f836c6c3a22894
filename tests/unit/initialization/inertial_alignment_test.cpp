#include <gtest/gtest.h>

#include <cmath>

#include "simulated_frames.h"

namespace vir::initialization {
namespace {

using vir_test::framesOf;
using vir_test::Scene;

InertialAlignment align(const std::vector<AlignmentFrame>& frames) {
  return alignInertial(frames, Scene::T_B_C(), Scene::kGravity, Scene::kFocal);
}

struct AlignmentError {
  double velocity = 0, tilt = 0, scale = 0, position = 0;
};

AlignmentError errorOf(const Scene& scene, const std::vector<AlignmentFrame>& frames,
                       const InertialAlignment& a) {
  AlignmentError e;
  const State first = scene.truth(frames.front().t);
  const Quat to_b0 = first.T_W_B.q.conjugate();
  const Vec3 g = to_b0 * Vec3(0, 0, -Scene::kGravity);
  e.tilt = std::acos(std::min(1.0, g.normalized().dot(a.g_B0.normalized())));
  double length = 0, estimated = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const State s = scene.truth(frames[k].t);
    const Vec3 p = to_b0 * (s.T_W_B.p - first.T_W_B.p);
    e.position = std::max(e.position, (p - a.p_B0[k]).norm());
    e.velocity = std::max(e.velocity, (to_b0 * s.v - a.v_B0[k]).norm());
    length += p.norm();
    estimated += a.p_B0[k].norm();
  }
  e.scale = std::abs(estimated / length - 1);
  return e;
}

TEST(InertialAlignment, ExactDataGiveVelocityGravityAndScale) {
  for (double t0 : {0.5, 2.0, 4.0, 7.0}) {
    Scene scene(vir_test::circling);
    const auto frames = framesOf(scene, t0, 11, 0.15, Vec3::Zero());
    const InertialAlignment a = align(frames);
    ASSERT_TRUE(a.ok) << a.reason;
    const AlignmentError e = errorOf(scene, frames, a);
    EXPECT_LT(e.velocity, 2e-3);
    EXPECT_LT(e.tilt, 3e-4);
    EXPECT_LT(e.scale, 2e-3);
    EXPECT_LT(e.position, 3e-3);
    EXPECT_NEAR(a.g_B0.norm(), Scene::kGravity, 1e-9);
    EXPECT_LT(a.residual_px, 0.1);
    ASSERT_EQ(a.q_B0_B.size(), frames.size());
    const Quat q =
        scene.truth(frames[0].t).T_W_B.q.conjugate() * scene.truth(frames.back().t).T_W_B.q;
    EXPECT_LT(a.q_B0_B.back().angularDistance(q), 1e-4);
  }
}

TEST(InertialAlignment, NoisyData) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Scene scene(vir_test::circling, seed);
    scene.noise_px = 0.3;
    scene.noise_gyro = 1.7e-4;
    scene.noise_acc = 2e-3;
    const auto frames = framesOf(scene, 0.7 * seed, 11, 0.2, Vec3::Zero());
    const InertialAlignment a = align(frames);
    ASSERT_TRUE(a.ok) << a.reason;
    const AlignmentError e = errorOf(scene, frames, a);
    EXPECT_LT(e.velocity, 0.15) << "seed " << seed;
    EXPECT_LT(e.tilt, 0.02) << "seed " << seed;
    EXPECT_LT(e.scale, 0.05) << "seed " << seed;
    EXPECT_LT(a.residual_px, 2);
  }
}

TEST(InertialAlignment, WrongMatchesAreOutvoted) {
  Scene scene(vir_test::circling, 3);
  scene.noise_px = 0.3;
  auto frames = framesOf(scene, 2.0, 11, 0.15, Vec3::Zero());
  vir_test::spoilTenPercent(&frames, 5);
  const InertialAlignment a = align(frames);
  ASSERT_TRUE(a.ok) << a.reason;
  const AlignmentError e = errorOf(scene, frames, a);
  EXPECT_LT(e.velocity, 0.15);
  EXPECT_LT(e.tilt, 0.02);
}

TEST(InertialAlignment, TooFewTracksIsRefused) {
  Scene scene(vir_test::circling);
  scene.max_tracks = 2;
  const InertialAlignment a = align(framesOf(scene, 1.0, 11, 0.15, Vec3::Zero()));
  EXPECT_FALSE(a.ok);
  EXPECT_EQ(a.reason, "too few tracks");
  EXPECT_FALSE(align({}).ok);
  Scene two(vir_test::circling);
  EXPECT_FALSE(align(framesOf(two, 1.0, 2, 0.15, Vec3::Zero())).ok) << "tracks of two sights only";
}

/// Without translation of the camera, scale and velocity cannot be told: the result must either be
/// refused or be right about what can be told (no motion).
void expectHonest(const vir_test::Motion& motion) {
  Scene scene(motion);
  scene.noise_px = 0.3;
  const auto frames = framesOf(scene, 1.0, 11, 0.15, Vec3::Zero());
  const InertialAlignment a = align(frames);
  if (!a.ok) {
    EXPECT_FALSE(a.reason.empty());
    return;
  }
  ASSERT_EQ(a.p_B0.size(), frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    EXPECT_TRUE(a.p_B0[k].allFinite() && a.v_B0[k].allFinite());
  }
  EXPECT_NEAR(a.g_B0.norm(), Scene::kGravity, 1e-9);
}

TEST(InertialAlignment, PureRotationIsRefusedOrFinite) {
  expectHonest([](double t) {
    // Turns about the camera's centre, not the body's.
    const Quat q = vir_test::circling(t).q;
    return Pose(q, -(q * Scene::T_B_C().p));
  });
}

TEST(InertialAlignment, StandingStillIsRefusedOrFinite) { expectHonest(vir_test::still); }

TEST(InertialAlignment, SteadyMotionHasNoScaleButIsFinite) {
  expectHonest([](double t) { return Pose(vir_test::still(0).q, Vec3(t, 0.2 * t, 0)); });
}

}  // namespace
}  // namespace vir::initialization
