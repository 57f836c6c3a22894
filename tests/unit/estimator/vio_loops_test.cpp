/// The class for programs of one's own, where it sees places again: a rendered flight in circles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "rendered_places.h"
#include "vir/core/angles.h"
#include "vir/core/settings.h"
#include "vir/estimator/vio.h"
#include "vir/rendering/make_scene.h"
#include "vir/simulation/flights.h"
#include "vir/simulation/simulate_imu.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

constexpr double kScale = 0.75, kRate_hz = 15;

/// Circles of 2 m radius, 8.4 s each, and what camera and IMU report there.
class Flight {
 public:
  static const Flight& get() {
    static const Flight flight;
    return flight;
  }

  /// Everything in [from_s, to_s) of the flight to `vio`, or what takes the same.
  template <class Taker>
  void play(Taker* vio, double from_s, double to_s) const {
    auto image = images_.begin();
    for (const ImuSample& s : imu_.samples) {
      const double at_s = toSeconds(s.t - motion_.begin());
      if (at_s < from_s || at_s >= to_s) continue;
      vio->add(s);
      for (; image != images_.end() && image->t <= s.t; ++image) {
        if (toSeconds(image->t - motion_.begin()) < from_s) continue;
        vio->add(Image{image->t, image->gray.width, image->gray.height, image->gray.pixels.data()});
      }
    }
    vio->finish();
  }
  Pose truth(TimeNs t) const {
    return motion_.poseAt(std::clamp(t, motion_.begin(), motion_.end()));
  }

  static Calibration calibration() {
    Calibration c;
    c.camera = vir_test::eurocCamera(kScale);
    c.T_B_C = vir_test::cameraInBody();
    return c;
  }

 private:
  struct Taken {
    TimeNs t;
    rendering::GrayImage gray;
  };

  Flight() : motion_(fly()) {
    std::vector<Vec3> path;
    for (const auto& s : motion_.sampled(4)) path.push_back(s.T_W_B.p);
    const auto scene = std::make_shared<rendering::Scene>(
        rendering::makeScene(rendering::SceneOptions(), path, {}));
    rendering::CameraSimulationOptions camera;
    camera.exposure_s = 0;
    vir_test::PlaceMaker maker(scene, calibration().camera, camera);
    for (double s = 0.05; s < motion_.duration() - 0.05; s += 1 / kRate_hz) {
      const TimeNs t = motion_.begin() + fromSeconds(s);
      images_.push_back({t, maker.take(motion_.poseAt(t), s)});
    }
    imu_ = simulation::simulateImu(motion_, {});
  }
  static simulation::Motion fly() {
    std::vector<Vec3> circles;
    for (int k = 0; k <= 18; ++k) {
      const double a = k * kPi / 6;
      circles.emplace_back(2 * std::sin(a), 2 - 2 * std::cos(a), 0);
    }
    simulation::FlightOptions o;
    o.height_m = 0.1;
    return simulation::flyAlong(circles, o);
  }

  simulation::Motion motion_;
  std::vector<Taken> images_;
  simulation::SimulatedImu imu_;
};

/// What a flight of some seconds told.
struct Told {
  explicit Told(const estimator::VioConfig& config, const std::string& map = "")
      : vio(Flight::calibration(), config) {
    if (!map.empty()) vio.loadMap(map);
    vio.onState([this](const StateEstimate& e) {
      if (!e.valid) return;
      states.push_back({e.state.t, e.state.T_W_B});
      uncorrected.push_back({e.state.t, vio.correction().inverse().pose() * e.state.T_W_B});
    });
    vio.onRevision([this](const Revision& r) { revised += r.keyframes.size(); });
  }
  Vio vio;
  Trajectory states, uncorrected;
  std::size_t revised = 0;
};

estimator::VioConfig config(bool loops) {
  estimator::VioConfig c;
  c.loops.use = loops;
  c.loops.options.finder.recent_s = 4;  // the next round comes after 8 s
  return c;
}

long accepted(const Vio& vio) {
  const auto all = vio.loops();
  return std::count_if(all.begin(), all.end(), [](const LoopRecord& r) { return r.accepted; });
}

double largestStep(const Trajectory& path) {
  double most = 0;
  for (std::size_t k = 1; k < path.size(); ++k) {
    most = std::max(most, (path[k].T_W_B.p - path[k - 1].T_W_B.p).norm());
  }
  return most;
}

TEST(VioLoops, ASecondRoundIsSeenAgain) {
  Told with(config(true)), without(config(false));
  Flight::get().play(&with.vio, 0, 100);
  Flight::get().play(&without.vio, 0, 100);
  EXPECT_GE(accepted(with.vio), 2);
  EXPECT_GT(with.revised, 0u);
  EXPECT_TRUE(without.vio.loops().empty());
  EXPECT_EQ(without.revised, 0u);
  EXPECT_EQ(without.vio.correction().yaw_rad, 0);
  ASSERT_GT(with.states.size(), 200u);
  ASSERT_EQ(with.states.size(), without.states.size());
  // The estimator hears nothing of loops.
  for (std::size_t k = 0; k < with.states.size(); ++k) {
    ASSERT_LT((with.uncorrected[k].T_W_B.p - without.states[k].T_W_B.p).norm(), 1e-9) << k;
  }
  EXPECT_FALSE(with.vio.landmarks().empty());
  EXPECT_GT(with.vio.keyframes().size(), 20u);
}

/// A run that begins on the way, in a W of its own, in a map of the whole round.
TEST(VioLoops, ARunIsFoundInAMapAndGoesOnInItsFrame) {
  const test::TempFolder folder;
  const std::string file = (folder / "round.virmap").string();
  Told first(config(true));
  Flight::get().play(&first.vio, 0, 10.5);
  first.vio.saveMap(file);
  Told second(config(true), file);
  EXPECT_FALSE(second.vio.found());
  Flight::get().play(&second.vio, 4, 10.4);
  ASSERT_TRUE(second.vio.found());
  EXPECT_TRUE(second.vio.warnings().empty()) << second.vio.warnings().front();
  // The map's frame is W of the first run: both lie on the truth in the same way.
  const Pose T_M_G =
      first.states.front().T_W_B * Flight::get().truth(first.states.front().t).inverse();
  const StampedPose& last = second.states.back();
  const Pose error = (T_M_G * Flight::get().truth(last.t)).inverse() * last.T_W_B;
  EXPECT_LT(error.p.norm(), 0.05);
  EXPECT_LT(error.q.angularDistance(Quat::Identity()), 0.02);
  // It is found by images of before its first pose, which is in the map already.
  const StampedPose& begun = second.states.front();
  EXPECT_LT((T_M_G * Flight::get().truth(begun.t).p - begun.T_W_B.p).norm(), 0.1);
  EXPECT_GT((begun.T_W_B.p - second.uncorrected.front().T_W_B.p).norm(), 0.5)
      << "its own world is elsewhere";
  EXPECT_LT(largestStep(second.uncorrected), 0.15) << "the estimator's path never does";
}

TEST(VioLoops, MapsThatCannotBeAreRefused) {
  const test::TempFolder folder;
  const std::string file = (folder / "a.virmap").string();
  Vio plain(Flight::calibration(), config(false));
  EXPECT_THROW(plain.loadMap(file), std::logic_error);
  EXPECT_THROW(plain.saveMap(file), std::logic_error);
  EXPECT_TRUE(plain.found());
  Vio vio(Flight::calibration(), config(true));
  EXPECT_THROW(vio.loadMap(file), std::runtime_error);
  EXPECT_THROW(vio.saveMap((folder / "no" / "where.virmap").string()), std::runtime_error);
  EXPECT_THROW(vio.saveMap(file), std::runtime_error);  // of nothing yet
  EXPECT_FALSE(std::filesystem::exists(file));
  Flight::get().play(&vio, 0, 4);
  vio.saveMap(file);
  ASSERT_TRUE(std::filesystem::exists(file));
  Calibration other = Flight::calibration();
  other.camera.fx *= 1.2;
  other.camera.fy *= 1.2;
  Vio another(other, config(true));
  EXPECT_THROW(another.loadMap(file), std::runtime_error);
  Vio twice(Flight::calibration(), config(true));
  twice.loadMap(file);
  EXPECT_THROW(twice.loadMap(file), std::logic_error);
}

TEST(VioLoops, SettingsOfAnIniHaveThem) {
  Settings settings;
  settings.set("Estimator.loops=false");
  settings.set("Loops.interval_s=0.7");
  const estimator::VioConfig config = estimator::configFrom(settings);
  EXPECT_FALSE(config.loops.use);
  EXPECT_EQ(config.loops.options.interval_s, 0.7);
  Settings wrong;
  wrong.set("Estimator.rawlog=a.rawlog");
  EXPECT_THROW(estimator::configFrom(wrong), SettingsError);
}

/// The estimator with loops whose answers count later.
struct LateLoops {
  explicit LateLoops(estimator::LoopTiming timing)
      : estimator(estimatorConfig()), loops(config(true).loops, {}, timing) {
    estimator.setCamera(Flight::calibration().camera, Flight::calibration().T_B_C);
    loops.setCamera(estimator.givenCalibration());
  }
  void add(const ImuSample& s) { estimator.addImu(s); }
  void add(const Image& image) {
    const cv::Mat gray(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels));
    loops.keep(image.t, gray);
    estimator.addImage(image.t, gray);
    take();
  }
  void finish() {
    estimator.finish();
    take();
    loops.finish(estimator);
    take();
  }
  void take() {
    const estimator::LoopedOutput out = loops.take(&estimator, 0, nullptr);
    for (const StateEstimate& e : out.states) {
      states.push_back({e.state.t, e.state.T_W_B});
      covariance += e.covariance.sum();
    }
    for (const Revision& r : out.revisions) {
      for (const StampedPose& k : r.keyframes) revised.push_back(k);
    }
  }
  static estimator::EstimatorConfig estimatorConfig() {
    estimator::EstimatorConfig c;
    c.tell_sights = true;
    return c;
  }
  estimator::VisualInertialEstimator estimator;
  estimator::LoopRun loops;
  Trajectory states, revised;
  double covariance = 0;
};

long accepted(const LateLoops& late) {
  const auto all = late.loops.records();
  return std::count_if(all.begin(), all.end(), [](const LoopRecord& r) { return r.accepted; });
}

/// When an answer counts is no matter of threads: the same to the last digit.
TEST(VioLoops, LateAnswersAreTheSameWithAThreadOfTheirOwn) {
  LateLoops here(estimator::LoopTiming::late), thread(estimator::LoopTiming::in_a_thread);
  Flight::get().play(&here, 0, 22);
  Flight::get().play(&thread, 0, 22);
  EXPECT_GE(accepted(here), 3);
  EXPECT_EQ(accepted(here), accepted(thread));
  EXPECT_EQ(here.covariance, thread.covariance);
  for (const auto& [a, b] :
       {std::pair{&here.states, &thread.states}, std::pair{&here.revised, &thread.revised}}) {
    ASSERT_GT(a->size(), 30u);
    ASSERT_EQ(a->size(), b->size());
    for (std::size_t i = 0; i < a->size(); ++i) {
      ASSERT_EQ((*a)[i].t, (*b)[i].t);
      ASSERT_EQ((*a)[i].T_W_B.p, (*b)[i].T_W_B.p) << i;
      ASSERT_EQ((*a)[i].T_W_B.q.coeffs(), (*b)[i].T_W_B.q.coeffs()) << i;
    }
  }
}

}  // namespace
}  // namespace vir
