/// What the robots of a made-up world record belongs together.
#include "world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "input_error.h"
#include "vir/core/settings.h"
#include "vir/evaluation/trajectory.h"
#include "vir_test_temp_folder.h"

namespace vir::simulator {
namespace {

SimulatorOptions twoRobots(const std::string& robot = "A") {
  SimulatorOptions o;
  o.robots = "A B";
  o.robot = robot;
  o.flight.length_m = 8;
  o.robot_options['A'];
  o.robot_options['B'].flight = "letter_t";
  o.robot_options['B'].start_m = {1, 3, 0.5};
  o.range_errors.anchor_m = {3, 2, 1.5};
  o.camera.width = 96;
  o.camera.height = 64;
  o.camera.fx_px = o.camera.fy_px = 60;
  o.camera.cx_px = 48;
  o.camera.cy_px = 32;
  return o;
}

template <typename What>
std::vector<std::pair<TimeNs, What>> all(const World& world) {
  std::vector<std::pair<TimeNs, What>> out;
  for (const Event& e : world.events()) {
    if (const auto* w = std::get_if<What>(&e.what)) out.emplace_back(e.t, *w);
  }
  return out;
}

TEST(SimulatedWorld, HoldsEverythingInTimeOrder) {
  const World world(twoRobots());
  const double s = world.motion().duration();
  for (std::size_t k = 1; k < world.events().size(); ++k) {
    EXPECT_LE(world.events()[k - 1].t, world.events()[k].t);
  }
  EXPECT_EQ(world.events().front().t, 1600000000LL * 1000000000);
  EXPECT_NEAR(static_cast<double>(all<ImuReading>(world).size()), 200 * s, 2);
  EXPECT_NEAR(static_cast<double>(all<ImageDue>(world).size()), 20 * s, 2);
  EXPECT_NEAR(static_cast<double>(all<TruePose>(world).size()), 100 * s, 2);
  EXPECT_GT(all<AnchorRange>(world).size(), 50u);
  EXPECT_GT(all<simulation::PeerRange>(world).size(), 20u);
  EXPECT_TRUE(all<OdometryPose>(world).empty());
  EXPECT_TRUE(all<TracksDue>(world).empty());
}

TEST(SimulatedWorld, TruthAndReadingsAreThoseOfTheMotion) {
  SimulatorOptions o = twoRobots("B");
  o.imu = {};  // without the errors of gain and alignment that the sensor has
  o.imu.gyro_noise_density = o.imu.acc_noise_density = 0;
  o.imu.initial_bias_gyro = o.imu.gyro_random_walk = 0;
  const World world(o);
  for (const auto& [t, truth] : all<TruePose>(world)) {
    EXPECT_LT((world.motion().poseAt(t).p - truth.T_W_B.p).norm(), 1e-12);
  }
  for (const auto& [t, imu] : all<ImuReading>(world)) {
    EXPECT_LT((world.motion().at(t).rate_B - imu.sample.gyro).norm(), 1e-12);
  }
}

TEST(SimulatedWorld, RobotsShareThePlaceAndTheirRanges) {
  World a(twoRobots("A")), b(twoRobots("B"));
  ASSERT_EQ(a.scene().boxes().size(), b.scene().boxes().size());
  for (std::size_t k = 0; k < a.scene().boxes().size(); ++k) {
    EXPECT_EQ(a.scene().boxes()[k].low, b.scene().boxes()[k].low);
  }
  const auto of_a = all<simulation::PeerRange>(a), of_b = all<simulation::PeerRange>(b);
  ASSERT_EQ(of_a.size(), of_b.size());
  for (std::size_t k = 0; k < of_a.size(); ++k) {
    EXPECT_EQ(of_a[k].first, of_b[k].first);
    EXPECT_EQ(of_a[k].second.range.range_m, of_b[k].second.range.range_m);
    EXPECT_EQ(of_a[k].second.range.anchor, 1);
    EXPECT_EQ(of_b[k].second.range.anchor, 0);
  }
  // But not their IMUs' errors.
  EXPECT_NE(all<ImuReading>(a)[0].second.sample.gyro, all<ImuReading>(b)[0].second.sample.gyro);
}

TEST(SimulatedWorld, SameSettingsSameEverything) {
  SimulatorOptions o = twoRobots();
  World a(o), b(o);
  o.seed = 1;
  World c(o);
  ASSERT_EQ(a.events().size(), b.events().size());
  const auto imu_a = all<ImuReading>(a), imu_b = all<ImuReading>(b), imu_c = all<ImuReading>(c);
  for (std::size_t k = 0; k < imu_a.size(); ++k) {
    EXPECT_EQ(imu_a[k].second.sample.acc, imu_b[k].second.sample.acc);
  }
  EXPECT_NE(imu_a[0].second.sample.acc, imu_c[0].second.sample.acc);
  std::uint64_t images = 0;
  for (const Event& e : a.events()) {
    if (!std::holds_alternative<ImageDue>(e.what) || ++images % 20 != 0) continue;
    const std::vector<std::uint8_t> pixels = a.image(e).pixels;
    EXPECT_EQ(pixels, b.image(e).pixels);
    EXPECT_NE(pixels, c.image(e).pixels);
  }
  EXPECT_GT(images, 20u);
}

TEST(SimulatedWorld, TheCamerasClockMayBeOff) {
  SimulatorOptions o = twoRobots();
  o.tracks = true;
  o.track_errors.noise_px = o.track_errors.offset_px = o.track_errors.drift_px = 0;
  o.track_errors.outlier_share = 0;
  World exact(o);
  o.camera.time_offset_s = 0.02;
  World late(o);
  const auto t0 = all<TracksDue>(exact), t1 = all<TracksDue>(late);
  ASSERT_EQ(t0.size(), t1.size());
  const TimeNs shift = fromSeconds(0.02);
  std::size_t k = 0;
  std::vector<vision::TrackedFrame> frames;
  for (const Event& e : exact.events()) {
    if (std::holds_alternative<TracksDue>(e.what)) frames.push_back(exact.tracks(e));
  }
  for (const Event& e : late.events()) {
    if (!std::holds_alternative<TracksDue>(e.what)) continue;
    const vision::TrackedFrame frame = late.tracks(e);
    EXPECT_EQ(frame.t, t0[k].first - shift);
    ASSERT_EQ(frame.features.size(), frames[k].features.size());
    for (std::size_t i = 0; i < frame.features.size(); i += 10) {
      EXPECT_EQ(frame.features[i].px, frames[k].features[i].px);
    }
    ++k;
  }
}

TEST(SimulatedWorld, TheCameraIsNotQuiteAsSaid) {
  CameraOptions o;
  double focal = 0, center = 0, turn = 0;
  constexpr int kSeeds = 400;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const TrueCamera c = trueCamera(o, seed);
    focal += std::pow(c.calibration.fx / o.fx_px - 1, 2) / kSeeds;
    EXPECT_NEAR(c.calibration.fy / o.fy_px, c.calibration.fx / o.fx_px, 1e-12);
    center += std::pow(c.calibration.cx - o.cx_px, 2) / kSeeds;
    turn += logQuat(mountOf(o).q.conjugate() * c.T_B_C.q).squaredNorm() / 3 / kSeeds;
  }
  EXPECT_NEAR(std::sqrt(focal), o.focal_error, 0.15 * o.focal_error);
  EXPECT_NEAR(std::sqrt(center), o.center_error_px, 0.15 * o.center_error_px);
  EXPECT_NEAR(std::sqrt(turn) * 180 / 3.14159265, o.mount_error_deg, 0.15 * o.mount_error_deg);
  o.focal_error = o.center_error_px = o.mount_error_deg = 0;
  EXPECT_EQ(trueCamera(o, 1).calibration.cx, o.cx_px);
  // The recording says what is printed on the box.
  EXPECT_EQ(World(twoRobots()).calibration().fx, 60);
}

TEST(SimulatedWorld, FliesAFileAgain) {
  const test::TempFolder folder;
  SimulatorOptions o = twoRobots();
  {
    const World world(o);
    std::ofstream out((folder / "a.tum").string());
    evaluation::writeTum(out, world.motion().sampled(100));
  }
  SimulatorOptions again = o;
  again.robot_options['A'].trajectory = (folder / "a.tum").string();
  again.robot_options['A'].start_m = {1, 0, 0};
  const World world(o), copy(again);
  const TimeNs begin = world.motion().begin();
  EXPECT_EQ(copy.motion().begin(), begin);
  EXPECT_NEAR(copy.motion().duration(), world.motion().duration(), 0.1);
  for (double s = 0.5; s < copy.motion().duration(); s += 0.5) {
    const TimeNs t = begin + fromSeconds(s);
    EXPECT_LT((copy.motion().poseAt(t).p - world.motion().poseAt(t).p - Vec3(1, 0, 0)).norm(),
              0.01);
  }
  again.robot_options['A'].trajectory = (folder / "none.tum").string();
  EXPECT_THROW(World{again}, InputError);
}

TEST(SimulatedWorld, SaysWhatCannotBe) {
  SimulatorOptions o = twoRobots();
  o.robots = "A A";
  EXPECT_THROW(lettersOf(o), SettingsError);
  o.robots = "AB";
  EXPECT_THROW(lettersOf(o), SettingsError);
  o.robots = "";
  EXPECT_THROW(lettersOf(o), SettingsError);
  o = twoRobots("C");
  EXPECT_THROW(recordedRobot(o), SettingsError);
  o = twoRobots("b");
  EXPECT_EQ(recordedRobot(o), 'B');
  o.range_errors.anchor_m = {1, 2};
  EXPECT_THROW(World{o}, InputError);
  o = twoRobots();
  o.camera_effects.dark_s = {1};
  EXPECT_THROW(World{o}, InputError);
  o = twoRobots();
  o.robot_options['B'].flight = "teapot";
  EXPECT_THROW(World{o}, InputError);
}

TEST(SimulatedWorld, OdometryBeginsAtTheRobot) {
  SimulatorOptions o = twoRobots();
  o.odometry = true;
  o.images = "none";
  const World world(o);
  const auto poses = all<OdometryPose>(world);
  ASSERT_GT(poses.size(), 100u);
  EXPECT_LT(poses.front().second.T_O_B.p.norm(), 0.01);
  EXPECT_TRUE(all<ImageDue>(world).empty());
}

}  // namespace
}  // namespace vir::simulator
