/// What becomes of a landmark when the frame that hosts it goes.
#include <gtest/gtest.h>

#include <cmath>

#include "vir_test_scene.h"
#include "window_state.h"

namespace vir::window {
namespace {

using vir_test::Scene;

/// A body that turns at 1 rad/s, seen at the camera's own time.
Pose turning(double t) { return {Quat(rotZ(t)), Vec3(0.4 * t, 0.1 * t, 0)}; }

Vec3 bearingAt(const Vec3& p_W, double t) {
  return ((turning(t) * Scene::T_B_C()).inverse() * p_W).normalized();
}

/// Three frames that see one landmark, hosted by the first, `td_s` after their stamps.
WindowState threeFrames(const Vec3& p_W, double td_s) {
  WindowState w;
  w.options.sigma_px = 1;
  factors::poseTo(Scene::T_B_C(), w.extrinsic);
  w.camera_parameters[factors::kTimeOffset] = td_s;
  WindowLandmark& l = w.landmarks[7];
  for (int k = 0; k < 3; ++k) {
    const double t = 0.1 * k;
    auto f = std::make_unique<Frame>();
    f->t = fromSeconds(t);
    factors::poseTo(turning(t), f->pose);
    w.frames.push_back(std::move(f));
    const Vec3 b = bearingAt(p_W, t + td_s);
    LandmarkSight s;
    s.frame = w.frames.back().get();
    s.sight.bearing = b;
    s.setRate((bearingAt(p_W, t + 1e-4) - bearingAt(p_W, t - 1e-4)) / 2e-4);
    s.sight.weight = Scene::observation(7, Scene::kFocal * b.head<2>() / b.z() +
                                               Vec2(Scene::kWidth, Scene::kHeight) / 2)
                         .dpx_dbearing;
    l.sights.push_back(s);
  }
  l.setHostRay();
  l.x[2] = 1 / ((turning(0) * Scene::T_B_C()).inverse() * p_W).norm();
  l.has_depth = true;
  return w;
}

Vec2 residualIn(const WindowState& w, std::size_t sight) {
  const WindowLandmark& l = w.landmarks.at(7);
  return factors::reprojectionResidual(l.ray, l.sights[sight].sight, l.host()->T_W_B(),
                                       l.sights[sight].frame->T_W_B(), w.T_B_C(),
                                       Vec3(l.x[0], l.x[1], l.x[2]), w.cameraVector(), nullptr);
}

/// The same three frames with their velocities, their sights `noise_px` beside.
WindowState sightsWithNoise(const Vec3& p_W, double noise_px) {
  WindowState w = threeFrames(p_W, 0);
  const Vec2 centre(Scene::kWidth / 2.0, Scene::kHeight / 2.0);
  double sign = 1;
  for (LandmarkSight& s : w.landmarks.at(7).sights) {
    s.frame->rate = Vec3(0, 0, 1);
    s.frame->speed_bias[0] = 0.4;
    s.frame->speed_bias[1] = 0.1;
    const Vec3 clean = s.sight.bearing;
    const Vec2 px =
        Scene::kFocal * clean.head<2>() / clean.z() + centre + noise_px * sign * Vec2(1, -1);
    const vision::FeatureObservation o = Scene::observation(7, px);
    s.sight.bearing = o.bearing;
    s.sight.weight = o.dpx_dbearing;
    s.off_centre = px - centre;
    // What a track tells: its noise over the time between two images.
    const Vec3 rate = -s.sight.by_camera.col(factors::kTimeOffset) + (o.bearing - clean) / 0.05;
    s.sight.by_camera = factors::bearingByCamera(px, o.dpx_dbearing, rate, centre, 0, Vec2::Zero());
    sign = -sign;
  }
  w.landmarks.at(7).setHostRay();
  return w;
}

/// Sights further off than three times what makes an outlier give no depth.
TEST(Landmarks, SightsThatContradictEachOtherGiveNoDepth) {
  for (const double off_px : {0.0, 9.0, 18.0}) {
    WindowState w = sightsWithNoise(Vec3(2, 0.5, 0.5), 0);
    w.options.min_parallax_px = 0;
    WindowLandmark& l = w.landmarks.at(7);
    l.has_depth = false;
    Vec3& bearing = l.sights.back().sight.bearing;
    bearing = (bearing + off_px / Scene::kFocal * Vec3::UnitX()).normalized();
    EXPECT_EQ(triangulateLandmarks(w), off_px < 3 * w.options.outlier_sigma ? 1 : 0) << off_px;
  }
}

/// Noise in a residual and in its own Jacobian pulls what is estimated to one side, however many
/// sights there are.
TEST(Landmarks, NoiseOfTheSightsIsNotInTheJacobiansOfTheCalibration) {
  const Vec3 p_W(5, 1, 0.5);
  WindowState clean = sightsWithNoise(p_W, 0), noisy = sightsWithNoise(p_W, 2);
  const auto difference = [&](factors::CameraParameter p) {
    double worst = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& a = clean.landmarks.at(7).sights[k].sight;
      const auto& b = noisy.landmarks.at(7).sights[k].sight;
      worst = std::max(worst, (a.weight * (a.by_camera.col(p) - b.by_camera.col(p))).norm());
    }
    return worst;  // [px/s] and [px]
  };
  EXPECT_GT(difference(factors::kTimeOffset), 20);
  EXPECT_GT(difference(factors::kFocal), 1);
  for (WindowState* w : {&clean, &noisy}) {
    WindowLandmark& l = w->landmarks.at(7);
    // As it is, whatever its host's noise says.
    const Vec3 ray = (turning(0) * Scene::T_B_C()).inverse() * p_W;
    const double along = ray.dot(l.ray.bearing);
    const Vec2 uv = l.ray.basis.transpose() * (ray / along - l.ray.bearing);
    l.x[0] = uv[0];
    l.x[1] = uv[1];
    l.x[2] = 1 / along;
    updateCameraJacobians(*w, &l);
  }
  EXPECT_LT(difference(factors::kTimeOffset), 0.5);
  EXPECT_LT(difference(factors::kFocal), 0.2);
  // And where there is no noise, they are what the track tells: by hand, the image's motion.
  const Vec3 rate = (bearingAt(p_W, 1e-4) - bearingAt(p_W, -1e-4)) / 2e-4;
  const auto& first = clean.landmarks.at(7).sights.front().sight;
  EXPECT_LT((first.by_camera.col(factors::kTimeOffset) + rate).norm(), 1e-6);
  EXPECT_LT((clean.landmarks.at(7).ray.by_camera - first.by_camera).norm(), 1e-15);
}

TEST(Landmarks, StayWhereTheyAreWithANewHost) {
  const Vec3 p_W(5, 1, 0.5);
  for (const double td : {0.0, 0.005, -0.02}) {
    WindowState w = threeFrames(p_W, td);
    const Vec3 before = landmarkInWorld(w, w.landmarks.at(7));
    EXPECT_LT((before - p_W).norm(), 0.01) << td;
    const Vec2 seen = residualIn(w, 2);
    EXPECT_LT(seen.norm(), 0.3) << td << ": the sights agree";
    removeSightsOf(w, w.frames.front().get());
    const WindowLandmark& l = w.landmarks.at(7);
    ASSERT_EQ(l.sights.size(), 2u);
    ASSERT_TRUE(l.has_depth);
    EXPECT_EQ(l.host(), w.frames[1].get());
    EXPECT_LT((landmarkInWorld(w, l) - before).norm(), 1e-12) << td;
    EXPECT_LT((residualIn(w, 1) - seen).norm(), 1e-9) << td;
    // What the host's own sight says of it: a pixel of noise at most, not the time offset.
    const Vec2 own = l.sights.front().sight.weight * (l.ray.basis * Vec2(l.x[0], l.x[1]));
    EXPECT_LT(own.norm(), 0.3) << td;
  }
}

TEST(Landmarks, LoseTheirDepthBehindTheNewHost) {
  WindowState w = threeFrames(Vec3(5, 1, 0.5), 0.005);
  factors::poseTo(Pose(Quat(rotZ(M_PI)), Vec3::Zero()), w.frames[1]->pose);
  removeSightsOf(w, w.frames.front().get());
  EXPECT_FALSE(w.landmarks.at(7).has_depth);
}

}  // namespace
}  // namespace vir::window
