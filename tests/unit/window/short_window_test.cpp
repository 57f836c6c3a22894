#include "vir/window/short_window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "window_driver.h"

namespace vir::window {
namespace {

using vir_test::Scene;
using vir_test::WindowDriver;

/// Eleven frames kept whatever the policy says, as an initialisation in motion does.
void fill(WindowDriver* d, double disturb) {
  for (int k = 0; k < 10; ++k) {
    d->push(0.15, disturb);
    d->window.keepNewest();
  }
}

void refine(WindowDriver* d, int rounds) {
  for (int k = 0; k < rounds; ++k) {
    d->window.triangulate();
    d->last = d->window.optimise(15);
    d->window.rejectOutliers();
  }
}

TEST(ShortWindow, ConvergesToTheTruthFromDisturbedPredictions) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    WindowDriver d(vir_test::circling, seed, WindowOptions(), 0.8 * seed);
    d.scene.bias_gyro = Vec3(0.01, -0.005, 0.008);
    State s = d.scene.truth(d.t);
    s.bg.setZero();
    s.v += Vec3(0.05, -0.04, 0.03);
    s.T_W_B.q = (expQuat(Vec3(0.005, -0.005, 0)) * s.T_W_B.q).normalized();  // tilt only
    d.start(s, StartPrior());
    fill(&d, 0.02);
    EXPECT_GT(d.positionError(), 0.02) << "the test must begin away from the truth";
    refine(&d, 5);
    ASSERT_TRUE(d.last.usable);
    EXPECT_GT(d.window.landmarksInNewest(), 15);
    for (const State& e : d.window.states()) {
      const State truth = d.scene.truth(e.t);
      EXPECT_LT((e.T_W_B.p - truth.T_W_B.p).norm(), 0.01) << "seed " << seed;
      EXPECT_LT(e.T_W_B.q.angularDistance(truth.T_W_B.q), 0.002) << "seed " << seed;
      EXPECT_LT((e.v - truth.v).norm(), 0.01) << "seed " << seed;
      EXPECT_LT((e.bg - truth.bg).norm(), 5e-4) << "seed " << seed;
    }
    EXPECT_LT(d.last.reprojection_rms, 0.1);
    for (const Landmark& l : d.window.landmarks()) {
      const double distance = (d.scene.point(l.id) - d.window.newest().T_W_B.p).norm();
      EXPECT_LT((l.p_W - d.scene.point(l.id)).norm(), 0.05 * distance) << "landmark " << l.id;
    }
  }
}

TEST(ShortWindow, BeginsWithTheStateThatItIsGiven) {
  WindowDriver d(vir_test::circling, 1, WindowOptions(), 0.8);
  State s = d.scene.truth(d.t);
  s.v = Vec3(0.1, 0.2, 0.3);
  s.bg = Vec3(0.01, 0.02, 0.03);
  s.ba = Vec3(-0.1, 0.15, -0.2);
  d.start(s, StartPrior());
  const State newest = d.window.newest();
  EXPECT_EQ(newest.t, s.t);
  EXPECT_EQ(newest.T_W_B.p, s.T_W_B.p);
  EXPECT_LT(newest.T_W_B.q.angularDistance(s.T_W_B.q), 1e-12);
  EXPECT_EQ(newest.v, s.v);
  EXPECT_EQ(newest.bg, s.bg);
  EXPECT_EQ(newest.ba, s.ba);
}

TEST(ShortWindow, AWrongMatchIsRejectedAndNothingElse) {
  WindowDriver d(vir_test::circling, 2, WindowOptions());
  d.start(d.scene.truth(d.t), StartPrior());
  fill(&d, 0);
  refine(&d, 2);
  std::set<std::uint64_t> known;
  for (const Landmark& l : d.window.landmarks()) known.insert(l.id);
  std::uint64_t wrong = 0;
  d.spoil = [&](std::vector<vision::FeatureObservation>* features) {
    for (vision::FeatureObservation& o : *features) {
      if (wrong != 0 || !known.count(o.id) || o.px.x() > 500) continue;
      wrong = o.id;
      o = Scene::observation(o.id, o.px + Vec2(30, 0));
    }
  };
  d.push(0.1);
  ASSERT_NE(wrong, 0u);
  d.window.keepNewest();
  d.window.triangulate();
  EXPECT_TRUE(d.window.optimise(5).usable);
  EXPECT_EQ(d.window.rejectOutliers(), std::vector<std::uint64_t>{wrong});
  for (const Landmark& l : d.window.landmarks()) EXPECT_NE(l.id, wrong);
  EXPECT_LT(d.positionError(), 0.005);
}

/// Little parallax is enough after a while, and not before.
TEST(ShortWindow, AfterTheLongestIntervalAThirdOfTheParallaxIsEnough) {
  WindowOptions options;
  options.keyframe_parallax_px = 60;
  for (const bool late : {false, true}) {
    WindowDriver d(vir_test::circling, 1, options);
    d.start(d.scene.truth(d.t), StartPrior());
    d.push(late ? 0.65 : 0.55);
    EXPECT_EQ(d.window.newestIsKeyframe(), late);
  }
}

/// Counted from the oldest frame, how well its own heading and place are known plays no part.
TEST(ShortWindow, TheCovarianceOfTheNewestIsAgainstTheOldest) {
  const auto covariance = [](double yaw_rad, double position_m) {
    WindowDriver d(vir_test::circling, 1, WindowOptions(), 0.8);
    StartPrior prior;
    prior.yaw_rad = yaw_rad;
    prior.position_m = position_m;
    d.start(d.scene.truth(d.t), prior);
    fill(&d, 0);
    refine(&d, 2);
    d.window.updateCovariance();
    return d.window.newestCovariance();
  };
  const Eigen::Matrix<double, 6, 6> sure = covariance(1e-3, 1e-3);
  for (const auto& [yaw_rad, position_m] : {std::pair(0.1, 1e-3), std::pair(1e-3, 0.3)}) {
    const Eigen::Matrix<double, 6, 6> unsure = covariance(yaw_rad, position_m);
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(std::sqrt(unsure(i, i)), std::sqrt(sure(i, i)), 0.05 * std::sqrt(sure(i, i)))
          << i << ", yaw " << yaw_rad << ", position " << position_m;
    }
  }
}

TEST(ShortWindow, KeyframePolicy) {
  WindowDriver still(vir_test::still, 1, WindowOptions());
  still.start(still.scene.truth(still.t), StartPrior());
  EXPECT_TRUE(still.window.newestIsKeyframe()) << "the first frame";
  still.push(2.0);
  EXPECT_FALSE(still.window.newestIsKeyframe()) << "no parallax, whatever the time";

  WindowDriver moving(vir_test::circling, 1, WindowOptions());
  moving.start(moving.scene.truth(moving.t), StartPrior());
  moving.push(0.02);
  EXPECT_FALSE(moving.window.newestIsKeyframe()) << "2.5 cm: a few pixels only";
  moving.window.slide(false);
  moving.push(0.5);
  EXPECT_TRUE(moving.window.newestIsKeyframe()) << "60 cm";

  WindowDriver turning(vir_test::turningOnTheSpot, 1, WindowOptions());
  turning.start(turning.scene.truth(turning.t), StartPrior());
  turning.push(0.2);
  EXPECT_FALSE(turning.window.newestIsKeyframe()) << "a turn has hardly any parallax";
  turning.window.slide(false);
  turning.push(1.5);
  EXPECT_TRUE(turning.window.newestIsKeyframe()) << "most tracks are new";
}

TEST(ShortWindow, KeyframePolicyAtRest) {
  WindowDriver d(vir_test::still, 1, WindowOptions());
  d.start(d.scene.truth(d.t), StartPrior(), true);
  d.push(0.1, 0, true);
  EXPECT_FALSE(d.window.newestIsKeyframe()) << "standing, and so was the last keyframe";
  d.window.slide(false);
  d.push(0.1, 0, false);
  EXPECT_TRUE(d.window.newestIsKeyframe()) << "takes off";
  d.window.slide(true);
  d.push(0.1, 0, true);
  EXPECT_TRUE(d.window.newestIsKeyframe()) << "stands again";
}

TEST(ShortWindow, NoTrackOrASingleOneIsNoTrouble) {
  for (std::size_t tracks : {std::size_t{0}, std::size_t{1}}) {
    WindowDriver d(vir_test::circling, 1, WindowOptions());
    d.scene.max_tracks = tracks;
    StartPrior p;
    p.tilt_rad = p.velocity_mps = 0.01;
    d.start(d.scene.truth(d.t), p);
    for (int k = 0; k < 20; ++k) {
      d.step(0.1);
      ASSERT_TRUE(d.last.usable) << tracks << " tracks, image " << k;
    }
    EXPECT_LT(d.positionError(), 0.05) << "two seconds on exact readings";
    EXPECT_TRUE(d.window.newestCovariance().allFinite());
  }
}

TEST(ShortWindow, FeaturesThatAreNotFiniteDoNotSpoilTheState) {
  WindowDriver d(vir_test::circling, 2, WindowOptions());
  d.start(d.scene.truth(d.t), StartPrior());
  fill(&d, 0);
  refine(&d, 2);
  d.spoil = [](std::vector<vision::FeatureObservation>* features) {
    for (vision::FeatureObservation& o : *features) o.bearing.setConstant(NAN);
  };
  d.push(0.1);
  d.window.triangulate();
  EXPECT_FALSE(d.window.optimise(3).usable) << "the estimator restarts on this";
  for (const State& e : d.window.states()) {
    EXPECT_TRUE(e.T_W_B.p.allFinite() && e.v.allFinite() && e.T_W_B.q.coeffs().allFinite());
  }
}

TEST(ShortWindow, ClearForgetsEverything) {
  WindowDriver d(vir_test::circling, 1, WindowOptions());
  d.start(d.scene.truth(d.t), StartPrior());
  fill(&d, 0);
  d.window.clear();
  EXPECT_TRUE(d.window.empty());
  EXPECT_EQ(d.window.frames(), 0);
  EXPECT_TRUE(d.window.landmarks().empty());
  EXPECT_TRUE(d.window.states().empty());
  d.start(d.scene.truth(d.t), StartPrior());
  EXPECT_EQ(d.window.frames(), 1);
}

TEST(Predict, FallsFreelyWithoutSpecificForce) {
  // 0.1 s from v = (1, 0, 0): p = (0.1, 0, -9.81 * 0.005), v_z = -0.981.
  imu::Preintegration link(imu::ImuNoise(), Vec3::Zero(), Vec3::Zero());
  link.integrate({0, Vec3::Zero(), Vec3::Zero()}, {100000000, Vec3::Zero(), Vec3::Zero()});
  State s;
  s.v = Vec3(1, 0, 0);
  const State e = predict(s, link, 9.81, 77);
  EXPECT_EQ(e.t, 77);
  EXPECT_LT((e.T_W_B.p - Vec3(0.1, 0, -0.04905)).norm(), 1e-12);
  EXPECT_LT((e.v - Vec3(1, 0, -0.981)).norm(), 1e-12);
}

}  // namespace
}  // namespace vir::window
