/// Whole flights (simulated tracks and readings) whose sensors do not do what they should.
#include <gtest/gtest.h>

#include <algorithm>

#include "looking_ahead.h"
#include "vir/geometry/so3.h"

namespace vir::estimator {
namespace {

using tool::RunResult;
using tool::RunSettings;
using tool::simulateRun;
using vir_test::flightOf;
using vir_test::lookingAhead;

/// With the shutter held to be a global one the flights of these seeds are 0.1 to 0.25 m off.
TEST(DisturbedFlight, ARollingShutterIsFoundAndCostsNothing) {
  const auto motion = flightOf("eight", 60);
  double global = 0, rolling = 0, held = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    RunSettings s = lookingAhead();
    const RunResult at_once = simulateRun(motion, s, seed);
    s.tracks.readout_s = 0.02;
    const RunResult found = simulateRun(motion, s, seed);
    s.estimator.window.calibration.readout_s = 1e-6;
    const RunResult not_looked_for = simulateRun(motion, s, seed);
    ASSERT_TRUE(at_once.valid && found.valid && not_looked_for.valid);
    EXPECT_NEAR(at_once.calibration.readout_s, 0, 1e-4) << "seed " << seed;
    EXPECT_NEAR(found.calibration.readout_s, 0.02, 0.001) << "seed " << seed;
    global += at_once.evaluation.ate_position_m.rmse / 3;
    rolling += found.evaluation.ate_position_m.rmse / 3;
    held += not_looked_for.evaluation.ate_position_m.rmse / 3;
  }
  std::printf("ATE: global shutter %.4f m, rolling %.4f m, not looked for %.4f m\n", global,
              rolling, held);
  EXPECT_LT(rolling, 1.3 * global + 0.005);
  EXPECT_GT(held, 1.5 * rolling) << "what the test is about must matter";
}

/// The first coefficient is 0.03 off: 2 px at the corner of the image.
TEST(DisturbedFlight, ALensThatIsOffIsFoundAndToldAndOneThatIsRightIsNot) {
  const auto motion = flightOf("eight", 60);
  double exact = 0, found = 0, held = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    RunSettings s = lookingAhead();
    s.camera.distortion = Distortion::radtan;
    s.camera.dist = {-0.28, 0.07};
    const RunResult right = simulateRun(motion, s, seed);
    s.given_camera = s.camera;
    s.given_camera->dist[0] = -0.25;
    const RunResult watched = simulateRun(motion, s, seed);
    s.estimator.window.lens = window::LensMode::given;
    const RunResult believed = simulateRun(motion, s, seed);
    ASSERT_TRUE(right.valid && watched.valid && believed.valid);
    EXPECT_EQ(right.calibration.camera.dist, s.camera.dist) << "seed " << seed;
    EXPECT_EQ(believed.calibration.camera.dist, s.given_camera->dist) << "seed " << seed;
    EXPECT_NEAR(watched.calibration.camera.dist[0], -0.28, 0.005) << "seed " << seed;
    const auto told = [](const RunResult& r) {
      return std::count_if(r.warnings.begin(), r.warnings.end(), [](const std::string& w) {
        return w.find("distortion of the lens") != std::string::npos;
      });
    };
    EXPECT_EQ(told(right), 0) << "seed " << seed;
    EXPECT_EQ(told(watched), 1) << "seed " << seed;
    exact += right.evaluation.ate_position_m.rmse / 3;
    found += watched.evaluation.ate_position_m.rmse / 3;
    held += believed.evaluation.ate_position_m.rmse / 3;
  }
  std::printf("ATE: exact lens %.4f m, found %.4f m, believed %.4f m\n", exact, found, held);
  EXPECT_LT(found, 2 * exact) << "until it is sure it flies with the wrong one";
  EXPECT_LT(found, 0.75 * held);
}

TEST(DisturbedFlight, TwoSecondsWithoutReadingsAreBridgedByTheImages) {
  const auto motion = flightOf("eight", 60);
  double whole = 0, bridged = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    RunSettings s = lookingAhead();
    const RunResult all = simulateRun(motion, s, seed);
    s.silent_imu_s = {14.0 + seed, 16.0 + seed};
    const RunResult silent = simulateRun(motion, s, seed);
    ASSERT_TRUE(all.valid && silent.valid);
    EXPECT_EQ(silent.resets, 0) << "seed " << seed;
    EXPECT_EQ(silent.estimate.size(), all.estimate.size()) << "a pose for every image";
    whole += all.evaluation.ate_position_m.rmse / 3;
    bridged += silent.evaluation.ate_position_m.rmse / 3;
  }
  std::printf("ATE: %.4f m, with 2 s missing %.4f m\n", whole, bridged);
  EXPECT_LT(bridged, 1.5 * whole + 0.03);
}

/// Turns faster than the gyro's range: what it says there is too little, and was believed.
TEST(DisturbedFlight, MotionBeyondTheSensorsRangeCostsLittle) {
  simulation::FlightOptions o;
  o.length_m = 120;
  o.speed_mps = 10;
  const auto motion = std::make_shared<simulation::Motion>(simulation::flight("eight", o));
  for (int seed = 1; seed <= 2; ++seed) {
    RunSettings s = lookingAhead();
    s.imu.saturation_gyro_radps = 2.2;
    const RunResult cut = simulateRun(motion, s, seed);
    ASSERT_TRUE(cut.valid);
    std::printf("ATE: %.3f m\n", cut.evaluation.ate_position_m.rmse);
    EXPECT_LT(cut.evaluation.ate_position_m.rmse, 0.15) << "seed " << seed;
  }
}

/// More in a row than are a spike, in the middle of the flight; what they say is left out where
/// the sights contradict it, and nothing else is.
TEST(DisturbedFlight, FalseReadingsAreLeftOutWhereTheImagesContradictThem) {
  struct Case {
    const char* what;
    double duration_s;
    std::function<ImuSample(const ImuSample&)> read;
    bool doubted;
  };
  const auto plus = [](const Vec3& gyro, const Vec3& acc) {
    return [gyro, acc](ImuSample s) {
      s.gyro += gyro;
      s.acc += acc;
      return s;
    };
  };
  const Case cases[] = {
      {"gyro", 0.025, plus(Vec3(1, -1, 0.5), Vec3::Zero()), false},
      {"gyro, longer", 0.2, plus(Vec3(1, -1, 0.5), Vec3::Zero()), false},
      {"accelerometer", 0.025, plus(Vec3::Zero(), Vec3(30, -30, 15)), false},
      {"accelerometer, longer", 0.2, plus(Vec3::Zero(), Vec3(30, -30, 15)), false},
      {"nothing but zeros", 1.0,
       [](ImuSample s) {
         s.gyro.setZero();
         s.acc.setZero();
         return s;
       },
       true},
  };
  const auto motion = flightOf("eight", 60);
  const RunSettings exact = lookingAhead();
  const RunResult whole = simulateRun(motion, exact, 1);
  ASSERT_TRUE(whole.valid);
  EXPECT_EQ(whole.counters.imu_contradicted, 0);
  EXPECT_EQ(whole.counters.images_misstamped, 0);
  for (const Case& c : cases) {
    RunSettings s = exact;
    s.false_imu_s = {15.0, 15.0 + c.duration_s};
    s.false_imu = c.read;
    const RunResult r = simulateRun(motion, s, 1);
    ASSERT_TRUE(r.valid) << c.what;
    std::printf("%s: ATE %.4f m (%.4f m), %ld images\n", c.what, r.evaluation.ate_position_m.rmse,
                whole.evaluation.ate_position_m.rmse, r.counters.imu_contradicted);
    EXPECT_EQ(r.resets, 0) << c.what;
    EXPECT_EQ(r.counters.images_misstamped, 0) << c.what;
    EXPECT_LT(r.evaluation.ate_position_m.rmse, 1.3 * whole.evaluation.ate_position_m.rmse + 0.02)
        << c.what;
    EXPECT_GE(r.counters.imu_contradicted, 1) << c.what;
    EXPECT_LE(r.counters.imu_contradicted, 3 + 20 * c.duration_s) << c.what;
    EXPECT_EQ(!r.doubts.empty(), c.doubted) << c.what;
    EXPECT_TRUE(std::any_of(r.warnings.begin(), r.warnings.end(), [](const std::string& w) {
      return w.find("bridged by the images") != std::string::npos;
    })) << c.what;
  }
}

/// Two images that exchange their stamps contradict the readings like a burst of false ones, but
/// fit them at each other's time.
TEST(DisturbedFlight, ImagesWithEachOthersStampsAreLeftOutAndTold) {
  const auto motion = flightOf("eight", 60);
  RunSettings s = lookingAhead();
  const RunResult whole = simulateRun(motion, s, 1);
  s.swapped_images_s = {10, 40};
  const RunResult r = simulateRun(motion, s, 1);
  ASSERT_TRUE(whole.valid && r.valid);
  std::printf("ATE: %.4f m (%.4f m), %ld images left out\n", r.evaluation.ate_position_m.rmse,
              whole.evaluation.ate_position_m.rmse, r.counters.images_misstamped);
  EXPECT_EQ(r.resets, 0);
  EXPECT_TRUE(r.doubts.empty()) << r.doubts.front();
  EXPECT_EQ(r.counters.imu_contradicted, 0);
  EXPECT_GE(r.counters.images_misstamped, 54);
  EXPECT_LE(r.counters.images_misstamped, 60);
  EXPECT_EQ(r.estimate.size(), whole.estimate.size()) << "a pose for every image";
  EXPECT_LT(r.evaluation.ate_position_m.rmse, 1.3 * whole.evaluation.ate_position_m.rmse + 0.02);
  EXPECT_EQ(std::count_if(r.warnings.begin(), r.warnings.end(),
                          [](const std::string& w) {
                            return w.find("images_misstamped counts them") != std::string::npos;
                          }),
            1);
}

/// Found while it starts in motion: what came before and the image of that very moment are put on
/// the clock that was found (an image left where it was ended runs with 120 ms and more).
TEST(DisturbedFlight, AClockThatIsFarOffIsFoundBeforeTheStart) {
  simulation::FlightOptions o;
  o.length_m = 40;
  o.rest_s = 0.1;
  const auto motion = std::make_shared<simulation::Motion>(simulation::flight("helix", o));
  for (const double late_s : {-0.19, -0.15, -0.12, 0.15}) {
    RunSettings s = lookingAhead();
    s.images_late_s = late_s;
    const RunResult r = simulateRun(motion, s, 1);
    ASSERT_TRUE(r.valid) << late_s << ": " << r.note;
    EXPECT_NEAR(r.calibration.time_offset_s, -late_s, 0.001);
    EXPECT_TRUE(r.doubts.empty()) << late_s << ": " << r.doubts.front();
    EXPECT_LT(r.evaluation.ate_position_m.rmse, 0.2) << late_s;
  }
}

/// Two quartzes: 200 millionths are 12 ms in a minute.
TEST(DisturbedFlight, AClockThatRunsFasterIsFollowed) {
  const auto motion = flightOf("eight", 80);
  double same = 0, drifting = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    RunSettings s = lookingAhead();
    const RunResult exact = simulateRun(motion, s, seed);
    s.camera_clock_ppm = 200;
    const RunResult r = simulateRun(motion, s, seed);
    ASSERT_TRUE(exact.valid && r.valid);
    EXPECT_TRUE(r.doubts.empty()) << r.doubts.front();
    EXPECT_NEAR(r.calibration.time_offset_s, -200e-6 * motion->duration(), 0.002);
    same += exact.evaluation.ate_position_m.rmse / 3;
    drifting += r.evaluation.ate_position_m.rmse / 3;
  }
  std::printf("ATE: %.4f m, with another clock's rate %.4f m\n", same, drifting);
  EXPECT_LT(drifting, 1.3 * same + 0.01);
}

/// Taken for a rest, three still seconds stop the flight: metres. On the readings alone they cost
/// centimetres.
TEST(DisturbedFlight, ACameraThatHangsIsNoRest) {
  const auto motion = flightOf("corridor", 60);
  for (int seed = 1; seed <= 3; ++seed) {
    RunSettings s = lookingAhead();
    s.frozen_camera_s = {14.0 + seed, 17.0 + seed};
    const RunResult r = simulateRun(motion, s, seed);
    ASSERT_TRUE(r.valid);
    EXPECT_EQ(r.resets, 0) << "seed " << seed;
    std::printf("seed %d: ATE %.4f m\n", seed, r.evaluation.ate_position_m.rmse);
    EXPECT_LT(r.evaluation.ate_position_m.rmse, 0.3) << "seed " << seed;
  }
}

/// A rawlog says by the identity that nobody knows where the camera is. This one looks along the
/// body's x axis, 120 deg from that.
TEST(DisturbedFlight, ACameraOfUnknownPoseIsFound) {
  const auto motion = flightOf("eight", 60);
  for (int seed = 1; seed <= 2; ++seed) {
    RunSettings s = lookingAhead();
    s.given_T_B_C = Pose();
    const RunResult r = simulateRun(motion, s, seed);
    ASSERT_TRUE(r.valid) << r.note;
    EXPECT_TRUE(r.doubts.empty()) << r.doubts.front();
    EXPECT_LT(logQuat(r.calibration.T_B_C.q.conjugate() * s.T_B_C.q).norm(), 0.01);
    EXPECT_LT((r.calibration.T_B_C.p - s.T_B_C.p).norm(), 0.02);
    EXPECT_LT(r.evaluation.ate_position_m.rmse, 0.12) << "seed " << seed;
  }
}

/// What was given is contradicted as soon as it turns: that is said, and a new segment begins with
/// the rotation that turning shows.
TEST(DisturbedFlight, ACameraGivenTheWrongWayRoundOrTurnedIsNamed) {
  const auto motion = flightOf("eight", 60);
  const RunSettings exact = lookingAhead();
  const Pose T = exact.T_B_C;
  const std::pair<Pose, const char*> cases[] = {
      {T.inverse(), "wrong way round"},
      // By 90 deg, as found before the first turn is over.
      {Pose{T.q * expQuat(Vec3(0, 0, EIGEN_PI / 2)), T.p}, "turned by 9"},
      {Pose{T.q * expQuat(Vec3(0, 0, EIGEN_PI)), T.p}, "are its images upside down?"},
      {Pose{T.q * expQuat(Vec3(EIGEN_PI, 0, 0)), T.p}, "images mirrored (left for right)?"},
      // Images of a mirror turn like this too.
      {Pose{T.q * expQuat(Vec3(0, EIGEN_PI, 0)), T.p}, "images mirrored (top for bottom)?"}};
  for (const auto& [given, text] : cases) {
    RunSettings s = exact;
    s.given_T_B_C = given;
    const RunResult r = simulateRun(motion, s, 1);
    ASSERT_TRUE(r.valid) << text << r.note;
    EXPECT_EQ(r.resets, 1) << text;
    EXPECT_TRUE(std::any_of(
        r.doubts.begin(), r.doubts.end(),
        [text = text](const std::string& d) { return d.find(text) != std::string::npos; }))
        << text << testing::PrintToString(r.doubts);
    EXPECT_LT(logQuat(r.calibration.T_B_C.q.conjugate() * T.q).norm(), 0.01) << text;
    EXPECT_LT(r.evaluation.ate_position_m.rmse, 0.3) << text;
  }
}

}  // namespace
}  // namespace vir::estimator
