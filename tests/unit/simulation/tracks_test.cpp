/// Simulated tracks look like those of the feature tracker.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <stdexcept>

#include "made_motions.h"
#include "vir/rendering/make_scene.h"
#include "vir/simulation/track_simulator.h"

namespace {

using namespace vir;

CameraCalibration calibration() {
  CameraCalibration c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 400;
  c.cx = 320;
  c.cy = 240;
  return c;
}

Pose forward() {
  Mat3 R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Quat(R), Vec3(0.05, 0.02, -0.01)};
}

vir::simulation::TrackSimulationOptions perfect() {
  vir::simulation::TrackSimulationOptions o;
  o.noise_px = o.offset_px = o.drift_px = 0;
  o.outlier_share = 0;
  return o;
}

vir::simulation::TrackSimulator simulator(
    const vir::simulation::TrackSimulationOptions& o,
    const std::shared_ptr<const vir::simulation::Motion>& motion) {
  return vir::simulation::TrackSimulator(o, motion, camera::makeCamera(calibration()), forward());
}

std::vector<vision::TrackedFrame> allFrames(
    const vir::simulation::TrackSimulationOptions& o,
    const std::shared_ptr<const vir::simulation::Motion>& motion) {
  vir::simulation::TrackSimulator s = simulator(o, motion);
  std::vector<vision::TrackedFrame> out;
  for (const TimeNs t : s.times()) out.push_back(s.at(t));
  return out;
}

TEST(SimulatedTracks, WithoutErrorsAreProjectionsOfTheirPoints) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::TrackSimulator s = simulator(perfect(), motion);
  const auto camera = camera::makeCamera(calibration());
  std::map<std::uint64_t, vision::FeatureObservation> before;
  TimeNs last = 0;
  for (const TimeNs t : s.times()) {
    const vision::TrackedFrame frame = s.at(t);
    EXPECT_EQ(frame.t, t);
    EXPECT_EQ(static_cast<std::size_t>(frame.continued + frame.detected - frame.lost_crowded),
              frame.features.size());
    std::map<std::uint64_t, vision::FeatureObservation> now;
    for (const vision::FeatureObservation& f : frame.features) {
      Vec3 p_W;
      ASSERT_TRUE(s.pointOf(f.id, &p_W));
      Vec2 px;
      ASSERT_TRUE(camera->project((motion->poseAt(t) * forward()).inverse() * p_W, &px));
      EXPECT_LT((px - f.px).norm(), 1e-9);
      Mat23 J;
      ASSERT_TRUE(camera->project(f.bearing, &px, &J));
      EXPECT_LT((px - f.px).norm(), 1e-6);
      EXPECT_LT((J - f.dpx_dbearing).norm(), 1e-9);
      const auto it = before.find(f.id);
      EXPECT_EQ(f.age > 0, it != before.end());
      if (it != before.end()) {
        EXPECT_EQ(f.age, it->second.age + 1);
        const Vec3 rate = (f.bearing - it->second.bearing) / toSeconds(t - last);
        EXPECT_LT((rate - f.bearing_rate).norm(), 1e-9);
      } else {
        EXPECT_EQ(f.bearing_rate, Vec3::Zero());
      }
      EXPECT_TRUE(now.empty() || now.rbegin()->first < f.id);
      now[f.id] = f;
    }
    before = now;
    last = t;
  }
}

TEST(SimulatedTracks, OfARollingShutterAreSeenAtTheTimesOfTheirRows) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::TrackSimulationOptions o = perfect();
  o.readout_s = 0.02;
  vir::simulation::TrackSimulator s = simulator(o, motion);
  const auto camera = camera::makeCamera(calibration());
  double moved = 0;
  for (const TimeNs t : s.times()) {
    for (const vision::FeatureObservation& f : s.at(t).features) {
      Vec3 p_W;
      ASSERT_TRUE(s.pointOf(f.id, &p_W));
      const TimeNs of_row = std::clamp(t + fromSeconds(0.02 * (f.px.y() / 480 - 0.5)),
                                       motion->begin(), motion->end());
      Vec2 px, all_at_once;
      ASSERT_TRUE(camera->project((motion->poseAt(of_row) * forward()).inverse() * p_W, &px));
      EXPECT_LT((px - f.px).norm(), 0.02);
      if (camera->project((motion->poseAt(t) * forward()).inverse() * p_W, &all_at_once)) {
        moved = std::max(moved, (all_at_once - f.px).norm());
      }
    }
  }
  EXPECT_GT(moved, 1) << "the flight is brisk enough for that to matter";
}

TEST(SimulatedTracks, ThereAreEnoughAllAlongEveryFlight) {
  for (const char* name : {"corridor", "route", "eight"}) {
    vir::simulation::FlightOptions flight_options;
    flight_options.length_m = 120;
    const auto motion =
        std::make_shared<vir::simulation::Motion>(vir::simulation::flight(name, flight_options));
    int fewest = 1000, most = 0;
    const auto frames = allFrames({}, motion);
    for (const vision::TrackedFrame& f : frames) {
      fewest = std::min(fewest, static_cast<int>(f.features.size()));
      most = std::max(most, static_cast<int>(f.features.size()));
    }
    EXPECT_GE(fewest, 100) << name;
    EXPECT_LE(most, 150) << name;
  }
}

TEST(SimulatedTracks, LiveAsLongAsSaid) {
  // At rest nothing leaves the image: only losses end a track.
  vir::simulation::TrackSimulationOptions o = perfect();
  o.weak_share = 0;
  o.mean_track_images = 20;
  double ends = 0, images = 0;
  for (const vision::TrackedFrame& f : allFrames(o, vir_test::standing(60))) {
    ends += f.lost_flow;
    images += static_cast<double>(f.continued + f.lost_flow);
  }
  EXPECT_NEAR(images / ends, 20, 1);
}

TEST(SimulatedTracks, HaveTheNoiseAskedFor) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::TrackSimulationOptions o = perfect();
  o.noise_px = 0.4;
  o.offset_px = 0.3;
  vir::simulation::TrackSimulator s = simulator(o, motion);
  const auto camera = camera::makeCamera(calibration());
  double total = 0, steps = 0, n_total = 0, n_steps = 0;
  std::map<std::uint64_t, Vec2> before;
  for (const TimeNs t : s.times()) {
    const double seconds = toSeconds(t - motion->begin());
    if (seconds < 6 || seconds > 40) {
      s.at(t);
      continue;
    }
    std::map<std::uint64_t, Vec2> now;
    for (const vision::FeatureObservation& f : s.at(t).features) {
      if (f.age == 0) continue;  // has its offset only
      Vec3 p_W;
      Vec2 px;
      ASSERT_TRUE(s.pointOf(f.id, &p_W));
      ASSERT_TRUE(camera->project((motion->poseAt(t) * forward()).inverse() * p_W, &px));
      const Vec2 e = f.px - px;
      now[f.id] = e;
      total += e.squaredNorm() / 2;
      ++n_total;
      if (!before.count(f.id)) continue;
      steps += (e - before[f.id]).squaredNorm() / 2;
      ++n_steps;
    }
    before = now;
  }
  EXPECT_NEAR(std::sqrt(total / n_total), 0.5, 0.03);
  EXPECT_NEAR(std::sqrt(steps / n_steps), 0.4 * std::sqrt(2.0), 0.02);
}

TEST(SimulatedTracks, AtRestTheImageHardlyMoves) {
  for (const vision::TrackedFrame& f : allFrames({}, vir_test::standing(5))) {
    EXPECT_LT(f.median_flow_px, 0.2);
  }
}

TEST(SimulatedTracks, SomeSlideOff) {
  vir::simulation::TrackSimulationOptions o = perfect();
  o.outlier_share = 0.1;
  o.weak_share = 0;
  const auto motion = vir_test::standing(30);
  vir::simulation::TrackSimulator s = simulator(o, motion);
  std::map<std::uint64_t, Vec2> first;
  std::map<std::uint64_t, double> far;
  for (const TimeNs t : s.times()) {
    for (const vision::FeatureObservation& f : s.at(t).features) {
      first.emplace(f.id, f.px);
      if (f.age >= 20) far[f.id] = (f.px - first[f.id]).norm();
    }
  }
  double slid = 0;
  for (const auto& [id, distance] : far) slid += distance > 1 ? 1 : 0;
  EXPECT_NEAR(slid / static_cast<double>(far.size()), 0.1, 0.03);
}

TEST(SimulatedTracks, DarkImagesAreReportedAndTracksEnd) {
  vir::simulation::TrackSimulationOptions o;
  o.blackout_s = {3, 5};
  const auto motion = vir_test::briskFlight();
  std::uint64_t newest_before = 0;
  for (const vision::TrackedFrame& f : allFrames(o, motion)) {
    const double s = toSeconds(f.t - motion->begin());
    const bool dark = s >= 3 && s < 5;
    EXPECT_EQ(f.usable, !dark) << s;
    EXPECT_EQ(f.reason.empty(), !dark);
    if (dark) {
      EXPECT_TRUE(f.features.empty());
    }
    if (s < 3) newest_before = std::max(newest_before, f.features.back().id);
    if (s >= 5) {
      for (const vision::FeatureObservation& x : f.features) EXPECT_GT(x.id, newest_before);
    }
  }
}

TEST(SimulatedTracks, DroppedOnesDoNotComeBack) {
  const auto motion = vir_test::standing(2);
  vir::simulation::TrackSimulator s = simulator(perfect(), motion);
  const auto times = s.times();
  const std::uint64_t id = s.at(times[0]).features.front().id;
  s.stopFollowing({id});
  for (std::size_t k = 1; k < times.size(); ++k) {
    for (const vision::FeatureObservation& f : s.at(times[k]).features) EXPECT_NE(f.id, id);
  }
}

TEST(SimulatedTracks, SameSeedSameTracks) {
  const auto motion = vir_test::briskFlight();
  const auto a = allFrames({}, motion), b = allFrames({}, motion);
  vir::simulation::TrackSimulationOptions other;
  other.seed = 2;
  const auto c = allFrames(other, motion);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].features.size(), b[k].features.size());
    for (std::size_t j = 0; j < a[k].features.size(); ++j) {
      EXPECT_EQ(a[k].features[j].id, b[k].features[j].id);
      EXPECT_EQ(a[k].features[j].px, b[k].features[j].px);
    }
  }
  EXPECT_NE(a[5].features[0].px, c[5].features[0].px);
}

TEST(SimulatedTracks, RefusesWhatCannotBe) {
  const auto motion = vir_test::standing(2);
  EXPECT_THROW(
      vir::simulation::TrackSimulator({}, nullptr, camera::makeCamera(calibration()), forward()),
      std::invalid_argument);
  vir::simulation::TrackSimulationOptions o;
  o.rate_hz = 0;
  EXPECT_THROW(simulator(o, motion), std::invalid_argument);
  o = {};
  o.blackout_s = {1};
  EXPECT_THROW(simulator(o, motion), std::invalid_argument);
  vir::simulation::TrackSimulator s = simulator({}, motion);
  s.at(motion->begin() + 10);
  EXPECT_THROW(s.at(motion->begin() + 10), std::invalid_argument);
}

TEST(SimulatedTracks, HideBehindTheScenesBoxes) {
  const auto motion = vir_test::briskFlight();
  std::vector<Vec3> path;
  for (const StampedPose& p : motion->sampled(4)) path.push_back(p.T_W_B.p);
  const auto scene = std::make_shared<rendering::Scene>(rendering::makeScene({}, path, {}));
  const auto camera = camera::makeCamera(calibration());
  vir::simulation::TrackSimulator s(perfect(), motion, camera, forward(), scene);
  std::size_t fewest = 1000;
  for (const TimeNs t : s.times()) {
    const vision::TrackedFrame frame = s.at(t);
    const Vec3 eye = (motion->poseAt(t) * forward()).p;
    fewest = std::min(fewest, frame.features.size());
    for (const vision::FeatureObservation& f : frame.features) {
      Vec3 p_W;
      ASSERT_TRUE(s.pointOf(f.id, &p_W));
      EXPECT_FALSE(scene->hidden(eye, p_W));
    }
  }
  EXPECT_GT(fewest, 100u);
}

}  // namespace
