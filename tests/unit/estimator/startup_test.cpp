/// What a start waits for, reason by reason, and what each of its settings does.
#include "vir/estimator/startup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <set>

#include "vir_test_scene.h"

namespace vir::estimator {
namespace {

using vir_test::Scene;

/// Images every 50 ms of the simulated scene, offered to a start.
Calibration calibration(const Pose& T_B_C) {
  Calibration c = Scene::calibration();
  c.T_B_C = T_B_C;
  return c;
}

struct Starter {
  explicit Starter(vir_test::Motion motion, const StartupOptions& options = {},
                   const Pose& T_B_C = Scene::T_B_C())
      : scene(std::move(motion)),
        startup(options, noise(), T_B_C, Scene::kFocal),
        window(window::WindowOptions(), noise(), calibration(T_B_C)) {}

  static imu::ImuNoise noise() {
    imu::ImuNoise n;
    n.noise_scale = 1;
    return n;
  }

  StartupStatus offer() {
    t += fromSeconds(0.05);
    for (; next_imu <= t + fromSeconds(0.005); next_imu += fromSeconds(0.005)) {
      ImuSample s = scene.imu(next_imu);
      if (spoil_imu) spoil_imu(&s);
      readings.add(s);
    }
    vision::TrackedFrame frame;
    frame.t = t;
    frame.features = scene.observe(t - late);
    if (spoil) spoil(&frame);
    rest.update(frame, readings);
    const StartupStatus status = startup.offer(frame, readings, rest, origin, &window);
    if (status == StartupStatus::waiting) reasons.insert(startup.reason());
    return status;
  }

  /// How long it took [s]; nothing if it has not started by then.
  std::optional<double> run(double longest_s) {
    const TimeNs begin = t;
    while (toSeconds(t - begin) < longest_s - 1e-6) {
      status = offer();
      if (status != StartupStatus::waiting) return toSeconds(t - begin);
    }
    return std::nullopt;
  }

  Scene scene;
  imu::ImuBuffer readings;
  RestDetector rest{RestOptions()};
  Startup startup;
  window::ShortWindow window;
  Pose origin;
  TimeNs t = fromSeconds(1.0), next_imu = fromSeconds(1.0);
  TimeNs late = 0;  ///< the stamps of the images against the readings'
  StartupStatus status = StartupStatus::waiting;
  std::set<std::string> reasons;
  std::function<void(vision::TrackedFrame*)> spoil;
  std::function<void(ImuSample*)> spoil_imu;
};

/// 3 cm/s, sideways.
Pose creeping(double t) { return {expQuat(Vec3(0, 0.1, 0)), Vec3(0, 0.03 * t, 0)}; }
/// Sideways at walking speed, without a turn.
Pose sideways(double t) { return {Quat::Identity(), Vec3(0, 1.0 * t, 0)}; }

TEST(Startup, InMotion) {
  Starter s(vir_test::circling);
  s.origin = Pose(Quat(rotZ(0.7)), Vec3(3, -2, 1));
  EXPECT_EQ(s.startup.reason(), "waiting for images");
  const State first = s.scene.truth(s.t + fromSeconds(0.05));
  const auto took = s.run(5);
  ASSERT_TRUE(took) << s.startup.reason() << ", " << s.startup.detail();
  EXPECT_EQ(s.status, StartupStatus::started_moving);
  EXPECT_GE(*took, StartupOptions().min_span_s);
  EXPECT_EQ(s.reasons.count("too few images"), 1u);
  EXPECT_FALSE(s.startup.detail().empty());
  EXPECT_EQ(s.window.newest().t, s.t);
  // Its first frame is at the origin, in position and yaw; from there on metric and level.
  const State a = s.window.oldest(), b = s.window.newest();
  EXPECT_LT((a.T_W_B.p - s.origin.p).norm(), 0.01);
  EXPECT_NEAR(yawOf(a.T_W_B.R()), 0.7, 0.01);
  const State truth_a = s.scene.truth(a.t), truth_b = s.scene.truth(b.t);
  const double moved = (truth_b.T_W_B.p - truth_a.T_W_B.p).norm();
  EXPECT_NEAR((b.T_W_B.p - a.T_W_B.p).norm() / moved, 1, 0.03);
  EXPECT_NEAR(b.v.norm(), truth_b.v.norm(), 0.05);
  EXPECT_EQ(first.t, a.t);
  s.startup.reset();
  EXPECT_EQ(s.startup.reason(), "waiting for images");
  EXPECT_EQ(s.startup.oldestTime(), 0);
}

TEST(Startup, Standing) {
  Starter s(vir_test::still);
  s.scene.bias_gyro = Vec3(0.02, -0.01, 0.03);
  const auto took = s.run(2);
  ASSERT_TRUE(took) << s.startup.reason();
  EXPECT_EQ(s.status, StartupStatus::started_standing);
  EXPECT_LT(*took, 0.7);
  EXPECT_LT((s.startup.gyroBias() - s.scene.bias_gyro).norm(), 1e-4);
  EXPECT_LT(s.window.newest().v.norm(), 1e-12);
  const Vec3 up = s.window.newest().T_W_B.R().transpose() * Vec3::UnitZ();
  const Vec3 truth = s.scene.truth(s.t).T_W_B.R().transpose() * Vec3::UnitZ();
  EXPECT_LT((up - truth).norm(), 1e-3);
}

TEST(Startup, WaitsForAnImageThatCanBeUsed) {
  Starter s(vir_test::circling);
  s.spoil = [](vision::TrackedFrame* f) {
    f->usable = false;
    f->reason = "dark";
  };
  EXPECT_FALSE(s.run(2));
  EXPECT_EQ(s.reasons, std::set<std::string>{"image not usable: dark"});
  EXPECT_EQ(s.startup.oldestTime(), 0) << "nothing to begin from";
}

TEST(Startup, WaitsForTracks) {
  for (const std::size_t tracks : {std::size_t{5}, std::size_t{20}}) {
    Starter s(vir_test::circling);
    s.scene.max_tracks = tracks;
    EXPECT_FALSE(s.run(3));
    EXPECT_EQ(s.startup.reason(), "too few tracks") << tracks;
  }
}

TEST(Startup, WaitsForParallax) {
  Starter s(creeping);
  EXPECT_FALSE(s.run(3));
  EXPECT_EQ(s.startup.reason(), "too little parallax");
}

TEST(Startup, WaitsForMoreThanATurn) {
  Starter s(vir_test::turningOnTheSpot);
  EXPECT_FALSE(s.run(3));
  EXPECT_EQ(s.startup.reason(), "rotation only");
}

TEST(Startup, WaitsForExcitation) {
  // A camera at the body's origin that moves, and an accelerometer that shows nothing, not even
  // gravity: no length to measure the motion by.
  const Pose centred(Scene::T_B_C().q, Vec3::Zero());
  Starter s(sideways, {}, centred);
  s.spoil_imu = [](ImuSample* sample) { sample->acc.setZero(); };
  EXPECT_FALSE(s.run(3));
  EXPECT_EQ(s.startup.reason(), "no excitation");
}

TEST(Startup, WaitsForTheScale) {
  StartupOptions strict;
  strict.max_scale_sigma = strict.patient_scale_sigma = 1e-4;
  Starter s(vir_test::circling, strict);
  EXPECT_FALSE(s.run(4));
  EXPECT_EQ(s.reasons.count("scale uncertain"), 1u);
}

TEST(Startup, WaitsForSightsThatAgree) {
  Starter s(vir_test::circling);
  s.scene.noise_px = 1.2;  // of the 0.3 px that the window expects
  EXPECT_FALSE(s.run(3));
  EXPECT_EQ(s.reasons.count("inconsistent"), 1u);
  EXPECT_TRUE(s.window.empty()) << "a refused start leaves nothing behind";
}

TEST(Startup, WaitsForTracksThatFit) {
  // Wrong by so much that hardly any track is one point for the camera: no landmarks to start with.
  Starter s(vir_test::circling);
  s.scene.noise_px = 4;
  EXPECT_FALSE(s.run(3));
  EXPECT_EQ(s.reasons.count("the tracks do not fit the camera's model and the readings"), 1u);
  EXPECT_TRUE(s.window.empty()) << "a refused start leaves nothing behind";
}

TEST(Startup, WaitsForAGyroThatCanBe) {
  Starter s(vir_test::turningOnTheSpot);
  s.scene.bias_gyro = Vec3(0.9, -0.9, 0.9);
  EXPECT_FALSE(s.run(1.3));
  EXPECT_EQ(s.reasons.count("implausible gyro bias"), 1u);
  EXPECT_TRUE(s.startup.gyroBias().isZero()) << "it is not taken over";
}

TEST(Startup, WaitsForTheClockOfTheCamera) {
  // Stamps that are 30 ms late are put right on the way. Those that are 150 ms late are beyond what
  // a start looks for: what the solver makes of them is refused.
  Starter near(vir_test::circling), far(vir_test::circling);
  near.late = fromSeconds(0.03);
  far.late = fromSeconds(0.15);
  for (Starter* s : {&near, &far}) s->startup.setTimeOffsetSigma(0.05);
  ASSERT_TRUE(near.run(3)) << near.startup.reason();
  EXPECT_NEAR(near.startup.foundShift(), -0.03, 0.002);
  EXPECT_FALSE(far.run(3)) << far.startup.foundShift();
  EXPECT_EQ(far.reasons.count("the camera's time offset is not known"), 1u);
  EXPECT_EQ(far.window.timeOffset(), 0) << "as it was given";
  EXPECT_TRUE(far.window.empty()) << "a refused start leaves nothing behind";
}

TEST(StartupOptions, Spans) {
  StartupOptions o;
  o.max_scale_sigma = o.patient_scale_sigma = 10;
  double last = 0;
  for (const double span : {0.5, 1.0, 1.6}) {
    o.min_span_s = span;
    Starter s(vir_test::circling, o);
    const auto took = s.run(4);
    ASSERT_TRUE(took) << span;
    EXPECT_GE(*took, span);
    EXPECT_GT(*took, last);
    last = *took;
  }
  o = {};
  o.allow_standing = false;
  for (const double span : {1.5, 2.5}) {
    o.max_span_s = span;
    Starter s(vir_test::still, o);
    EXPECT_FALSE(s.run(4));
    EXPECT_EQ(s.startup.oldestTime(), s.t - fromSeconds(span));
  }
}

TEST(StartupOptions, AllowStanding) {
  StartupOptions o;
  o.allow_standing = false;
  Starter s(vir_test::still, o);
  EXPECT_FALSE(s.run(3));
  EXPECT_EQ(s.startup.reason(), "standing still");
}

TEST(StartupOptions, ScaleSigmaAndPatience) {
  Starter at_once(vir_test::circling);
  const auto first = at_once.run(4);
  ASSERT_TRUE(first);
  StartupOptions o;
  o.max_scale_sigma = 1e-4;
  o.patient_scale_sigma = 10;
  for (const double patience : {1.8, 2.6}) {
    o.patience_s = patience;
    Starter s(vir_test::circling, o);
    const auto took = s.run(4);
    ASSERT_TRUE(took) << patience;
    EXPECT_GT(*took, *first);
    EXPECT_NEAR(*took, patience + 0.1, 0.1) << "counted from the first image";
    EXPECT_EQ(s.reasons.count("scale uncertain"), 1u);
  }
}

TEST(StartupOptions, TiltSigma) {
  StartupOptions o;
  o.max_tilt_sigma_deg = 1e-3;
  Starter s(vir_test::circling, o);
  EXPECT_FALSE(s.run(3));
  EXPECT_EQ(s.startup.reason(), "scale uncertain");
}

TEST(StartupOptions, ParallaxAndSharedTracks) {
  StartupOptions o;
  o.min_parallax_px = 900;
  Starter far(vir_test::circling, o);
  EXPECT_FALSE(far.run(3));
  EXPECT_EQ(far.startup.reason(), "too little parallax");
  o = {};
  o.min_shared_tracks = 61;  // of 60
  Starter many(vir_test::circling, o);
  EXPECT_FALSE(many.run(3));
  EXPECT_EQ(many.startup.reason(), "too few tracks");
  o.min_shared_tracks = 8;
  Starter few(vir_test::circling, o);
  few.scene.max_tracks = 20;
  few.run(3);
  EXPECT_NE(few.reasons, std::set<std::string>({"too few images", "too few tracks"}))
      << "20 tracks are looked at now";
}

TEST(StartupOptions, ReprojectionRms) {
  StartupOptions o;
  o.max_reprojection_rms = 0.1;
  Starter strict(vir_test::circling, o), easy(vir_test::circling);
  strict.scene.noise_px = easy.scene.noise_px = 0.1;
  EXPECT_FALSE(strict.run(3));
  EXPECT_EQ(strict.reasons.count("inconsistent"), 1u);
  EXPECT_TRUE(easy.run(3));
}

/// The state a start ends with, with noise so that nothing is exact.
State startedWith(const StartupOptions& o, Vec3* gyro_bias_before = nullptr) {
  Starter s(vir_test::circling, o);
  s.scene.noise_px = 0.1;
  s.scene.bias_acc = Vec3(0.1, -0.08, 0.05);
  EXPECT_TRUE(s.run(6)) << s.startup.reason();
  if (gyro_bias_before) *gyro_bias_before = s.startup.gyroBias();
  return s.window.newest();
}

TEST(StartupOptions, Iterations) {
  StartupOptions once, often;
  once.iterations = 1;
  EXPECT_GT((startedWith(once).T_W_B.p - startedWith(often).T_W_B.p).norm(), 1e-6);
}

TEST(StartupOptions, SigmaOfTheBiases) {
  StartupOptions o;
  o.sigma_bias_acc = 1e-5;
  EXPECT_LT(startedWith(o).ba.norm(), 1e-2);
  EXPECT_GT(startedWith({}).ba.norm(), 2e-2);
  o = {};
  Vec3 before = Vec3::Zero();
  o.sigma_bias_gyro = 1e-6;
  const double held = (startedWith(o, &before).bg - before).norm();
  const double free = (startedWith({}, &before).bg - before).norm();
  EXPECT_LT(held, 0.2 * free);
}

}  // namespace
}  // namespace vir::estimator
