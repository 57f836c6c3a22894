/// What the images' turning says of the clocks and of the camera's rotation.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "simulated_frames.h"
#include "vir/initialization/image_turn.h"

namespace vir::initialization {
namespace {

using vir_test::Scene;

struct Recorded {
  imu::ImuBuffer imu;
  std::vector<ImageTurn> turns;
};

/// Two seconds of images every 50 ms from t0 on, stamped `late_s` after they were taken.
Recorded record(vir_test::Motion motion, double late_s, double noise_px, unsigned seed = 1,
                bool spoil = false) {
  Scene scene(std::move(motion), seed);
  scene.max_tracks = 120;
  scene.noise_px = noise_px;
  scene.bias_gyro = Vec3(0.02, -0.03, 0.01);
  Recorded out;
  for (int k = 0; k <= 560; ++k) out.imu.add(scene.imu(fromSeconds(0.6 + 0.005 * k)));
  std::vector<AlignmentFrame> frames;
  for (int k = 0; k < 40; ++k) {
    const TimeNs t = fromSeconds(1 + 0.05 * k);
    AlignmentFrame f{
        t + fromSeconds(late_s), {}, imu::Preintegration({}, Vec3::Zero(), Vec3::Zero())};
    for (const vision::FeatureObservation& o : scene.observe(t))
      f.sights.push_back({o.id, o.bearing});
    frames.push_back(std::move(f));
  }
  if (spoil) vir_test::spoilTenPercent(&frames, 3);
  for (std::size_t k = 2; k < frames.size(); ++k) {
    const auto turn = turnBetween(frames[k - 2].t, frames[k - 2].sights, frames[k].t,
                                  frames[k].sights, Scene::kFocal);
    if (turn) out.turns.push_back(*turn);
  }
  return out;
}

TEST(TurnBetween, FindsTheRotationWithoutAGyro) {
  Scene scene(vir_test::circling, 3);
  scene.max_tracks = 120;
  const TimeNs t0 = fromSeconds(1), t1 = fromSeconds(1.1);
  std::vector<AlignmentSight> a, b;
  for (const auto& o : scene.observe(t0)) a.push_back({o.id, o.bearing});
  for (const auto& o : scene.observe(t1)) b.push_back({o.id, o.bearing});
  const auto turn = turnBetween(t0, a, t1, b, Scene::kFocal);
  ASSERT_TRUE(turn);
  const Quat q_W_C0 = scene.truth(t0).T_W_B.q * Scene::T_B_C().q;
  const Quat q_W_C1 = scene.truth(t1).T_W_B.q * Scene::T_B_C().q;
  EXPECT_LT((turn->rate_C - logQuat(q_W_C0.conjugate() * q_W_C1) / 0.1).norm(), 1e-6);
  const Eigen::SelfAdjointEigenSolver<Mat3> eig(turn->information);
  EXPECT_GT(eig.eigenvalues().minCoeff(), 0);
}

TEST(TurnBetween, RefusesWhatItCannotTell) {
  std::vector<AlignmentSight> few;
  for (std::uint64_t k = 0; k < 11; ++k) few.push_back({k, Vec3(0.01 * k, 0, 1).normalized()});
  EXPECT_FALSE(turnBetween(0, few, 1000, few, 400));
  EXPECT_FALSE(turnBetween(0, {}, 1000, {}, 400));
  std::vector<AlignmentSight> many;
  for (std::uint64_t k = 0; k < 40; ++k) {
    many.push_back({k, Vec3(std::sin(k), std::cos(3.0 * k), 2).normalized()});
  }
  EXPECT_FALSE(turnBetween(1000, many, 1000, many, 400)) << "no time between them";
}

TEST(CorrelateTurns, FindsTheOffset) {
  for (const double late : {0.0, 0.005, -0.02, 0.07, -0.15, 0.19}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const Recorded r = record(vir_test::flying, late, 0.3, seed);
      const TurnCorrelation c = correlateTurns(r.turns, r.imu, Scene::T_B_C().q);
      ASSERT_TRUE(c.ok) << late << ": " << c.reason;
      EXPECT_NEAR(c.offset_s, -late, 0.008) << late << " seed " << seed;
      EXPECT_NEAR(c.offset_s, -late, 4 * c.sigma_s) << late << " seed " << seed;
      EXPECT_LT(c.sigma_s, 0.008);
      EXPECT_LT((c.gyro_bias - Vec3(0.02, -0.03, 0.01)).norm(), 0.05);
      if (std::abs(late) > 0.05) {
        EXPECT_GT(c.against_none, 30);
      }
      if (late == 0) {
        EXPECT_LT(c.against_none, 16);
      }
    }
  }
}

TEST(CorrelateTurns, IsNotMisledByWrongMatches) {
  const Recorded r = record(vir_test::flying, 0.04, 0.3, 2, true);
  const TurnCorrelation c = correlateTurns(r.turns, r.imu, Scene::T_B_C().q);
  ASSERT_TRUE(c.ok) << c.reason;
  EXPECT_NEAR(c.offset_s, -0.04, 0.01);
}

TEST(CorrelateTurns, SaysWhenItCannotTell) {
  const Recorded still = record(vir_test::still, 0.05, 0.3);
  const TurnCorrelation c = correlateTurns(still.turns, still.imu, Scene::T_B_C().q);
  EXPECT_FALSE(c.ok);
  EXPECT_FALSE(c.reason.empty());
  EXPECT_EQ(correlateTurns({}, still.imu, Scene::T_B_C().q).reason, "too few images");
  const Recorded far = record(vir_test::flying, 0.35, 0.3);
  EXPECT_FALSE(correlateTurns(far.turns, far.imu, Scene::T_B_C().q).ok) << "out of reach";
  EXPECT_FALSE(correlateTurns(far.turns, imu::ImuBuffer(), Scene::T_B_C().q).ok);
}

TEST(FindCameraRotation, FromNothing) {
  for (const double late : {0.0, 0.06}) {
    const Recorded r = record(vir_test::flying, late, 0.3);
    const CameraRotation c = findCameraRotation(r.turns, r.imu);
    ASSERT_TRUE(c.ok) << c.explained << " " << c.sigma_rad;
    EXPECT_LT(c.q_B_C.angularDistance(Scene::T_B_C().q), 0.1) << late;
    EXPECT_NEAR(c.offset_s, -late, 0.013);
  }
  const Recorded still = record(vir_test::still, 0, 0.3);
  EXPECT_FALSE(findCameraRotation(still.turns, still.imu).ok);
}

}  // namespace
}  // namespace vir::initialization
