/// From rendered images to corrections, maps, and a run that is found in a map.
#include "vir/mission/loop_closer.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "rendered_places.h"
#include "vir/camera/camera_model.h"
#include "vir/mission/map_merge.h"
#include "vir/rendering/make_scene.h"

namespace vir::mission {
namespace {

using vir_test::bodyAt;
using vir_test::cameraInBody;
using vir_test::PlaceMaker;

constexpr int kVisit = 14;

/// Along a room, a look to the side, 0.4 m from image to image.
Pose onTheWay(int k, double aside = 0) {
  return bodyAt(Vec3(-3 + 0.4 * k, aside, 1.2 + 0.05 * std::sin(k)), 0.2 + 0.02 * k, 0.02, -0.03);
}

Calibration cameraOf() {
  Calibration c;
  c.camera = vir_test::eurocCamera(0.75);
  c.T_B_C = cameraInBody();
  return c;
}

std::shared_ptr<const rendering::Scene> room(int seed) {
  rendering::SceneOptions o;
  o.seed = seed;
  std::vector<Vec3> way;
  for (int k = 0; k < kVisit; ++k) way.push_back(onTheWay(k).p);
  return std::make_shared<rendering::Scene>(rendering::makeScene(o, way, {}));
}

/// A robot whose estimator is off by `drift` by now.
struct Robot {
  explicit Robot(int scene = 3) : maker(room(scene), cameraOf().camera, options()) {}
  static rendering::CameraSimulationOptions options() {
    rendering::CameraSimulationOptions o;
    o.seed = 5;
    return o;
  }

  void see(LoopCloser* closer, const Pose& truth, const Pose& drift, double s, double sigma_m,
           int segment = 0) {
    const rendering::GrayImage& image = maker.take(truth, s);
    SeenKeyframe seen;
    seen.gray.width = image.width;
    seen.gray.height = image.height;
    seen.gray.pixels = image.pixels.data();
    seen.landmarks = maker.seen(image, truth * cameraInBody());
    StateEstimate& e = seen.estimate;
    e.valid = e.keyframe = true;
    e.state.t = fromSeconds(1000 + s);
    e.state.T_W_B = drift * truth;
    e.segment = segment;
    e.covariance.diagonal() << Vec3::Constant(sigma_m * sigma_m), Vec3::Constant(1e-4);
    e.calibration = told;
    closer->add(seen);
    last = e;
    if (closer->solveDue()) closer->solve({});
  }
  /// One visit, and what the closer says of its last pose.
  Pose visit(LoopCloser* closer, const Pose& drift, double begin_s, double sigma_m,
             double aside = 0, int segment = 0) {
    for (int k = 0; k < kVisit; ++k) {
      see(closer, onTheWay(k, aside), drift, begin_s + 0.5 * k, sigma_m, segment);
    }
    return closer->correction().pose() * drift * onTheWay(kVisit - 1, aside);
  }

  PlaceMaker maker;
  Calibration told;  ///< as the estimator has it; without intrinsics: as given
  StateEstimate last;
};

const Pose kDrift(Quat(rotZ(0.03)), Vec3(0.3, -0.2, 0.1));

TEST(LoopCloser, ASecondVisitTakesTheDriftOff) {
  Robot robot;
  LoopCloser closer({}, cameraOf());
  robot.visit(&closer, Pose(), 0, 0.01);
  EXPECT_TRUE(closer.records().empty());
  const Pose last = robot.visit(&closer, kDrift, 60, 0.5, 0.15);
  const Pose truth = onTheWay(kVisit - 1, 0.15);
  EXPECT_LT((last.p - truth.p).norm(), 0.05);
  EXPECT_LT(last.q.angularDistance(truth.q), 0.02);
  closer.solve({});
  const auto revision = closer.takeRevision();
  ASSERT_TRUE(revision);
  EXPECT_FALSE(closer.takeRevision());
  EXPECT_LT((closer.correctionAt(fromSeconds(1000)).pose() * onTheWay(0).p - onTheWay(0).p).norm(),
            0.03);
  long accepted = 0;
  for (const LoopRecord& r : closer.records()) {
    if (!r.accepted) continue;
    ++accepted;
    EXPECT_EQ(r.decision, "accepted");
    EXPECT_FALSE(r.in_map);
    EXPECT_LT(r.t_older, r.t_newer);
  }
  EXPECT_GE(accepted, 3);
  EXPECT_GT(closer.landmarks().size(), 100u);
}

/// A pose is known as well as the first visit once it was tied to it; roll and pitch are not the
/// path's.
TEST(LoopCloser, TheCovarianceShrinksToWhatIsKnown) {
  Robot robot;
  LoopCloser closer({}, cameraOf());
  robot.visit(&closer, Pose(), 0, 0.01);
  StateEstimate before = robot.last;
  closer.now().apply(&before);
  EXPECT_EQ(before.covariance, robot.last.covariance);
  robot.visit(&closer, kDrift, 60, 0.5, 0.15);
  closer.solve({});
  StateEstimate after = robot.last;
  closer.now().apply(&after);
  const Pose truth = onTheWay(kVisit - 1, 0.15);
  const Vec3 error = after.state.T_W_B.p - truth.p;
  const Mat3 P = after.covariance.topLeftCorner<3, 3>();
  EXPECT_LT(std::sqrt(P.trace() / 3), 0.1);
  EXPECT_LT(error.dot(P.ldlt().solve(error)), 11.3);  // 99 % of three degrees of freedom
  const Mat3 R = after.state.T_W_B.R();
  const Mat3 of_turn = R * after.covariance.bottomRightCorner<3, 3>() * R.transpose();
  EXPECT_NEAR(of_turn(0, 0), 1e-4, 1e-9);
  EXPECT_NEAR(of_turn(1, 1), 1e-4, 1e-9);
  EXPECT_LT(of_turn(2, 2), 1.2e-4);
  EXPECT_LT((after.covariance - after.covariance.transpose()).norm(), 1e-12);
}

/// The first visit was seen with a wrong calibration, which the estimator has mended by the second.
TEST(LoopCloser, KeyframesSeeWithTheCalibrationThatIsKnownByNow) {
  Robot robot;
  Calibration given = cameraOf();
  given.camera.fx *= 1.012;
  given.camera.fy *= 1.012;
  given.camera.cx += 3;
  given.T_B_C.q = given.T_B_C.q * expQuat(Vec3(0.01, 0.015, -0.01));
  LoopCloser closer({}, given);
  robot.visit(&closer, Pose(), 0, 0.01);
  robot.told = cameraOf();
  robot.visit(&closer, kDrift, 60, 0.5, 0.15);
  const auto camera = camera::makeCamera(cameraOf().camera);
  std::size_t points = 0;
  for (const auto& k : closer.map(cameraOf(), {}).keyframes) {
    EXPECT_LT(k->T_B_C.q.angularDistance(cameraOf().T_B_C.q), 1e-12);
    for (const PlacePoint& p : k->points) {
      Vec3 ray;
      ASSERT_TRUE(camera->unproject(p.px.cast<double>(), &ray));
      EXPECT_LT((ray - p.ray_C.cast<double>()).norm(), 1e-6);
      ++points;
    }
  }
  EXPECT_GT(points, 1000u);
  EXPECT_LT((closer.correction().pose() * kDrift * onTheWay(kVisit - 1, 0.15).p -
             onTheWay(kVisit - 1, 0.15).p)
                .norm(),
            0.05);
}

TEST(LoopCloser, AnotherRoomIsNoSecondVisit) {
  Robot one(3), other(4);
  LoopCloser closer({}, cameraOf());
  one.visit(&closer, Pose(), 0, 0.01);
  other.visit(&closer, kDrift, 60, 0.5);
  for (const LoopRecord& r : closer.records()) EXPECT_FALSE(r.accepted);
  EXPECT_LT(closer.correction().t_m.norm(), 1e-9);
}

TEST(LoopCloser, StandingStillNothingIsAdded) {
  Robot robot;
  LoopCloser closer({}, cameraOf());
  for (int k = 0; k < 5; ++k) robot.see(&closer, onTheWay(0), Pose(), k, 0.01);
  EXPECT_EQ(closer.counters().front().second, 1);
}

TEST(KeyframePace, WhatIsTooNearToTheLastOneIsPassedOver) {
  const LoopOptions o;
  KeyframePace pace(o);
  StateEstimate e;
  EXPECT_FALSE(pace.wants(e, true));  // no state
  e.valid = true;
  e.state.t = fromSeconds(5);
  EXPECT_TRUE(pace.wants(e, true));
  pace.took(e);
  EXPECT_FALSE(pace.wants(e, true));
  e.state.T_W_B.p.x() = 2 * o.moved_m;
  e.state.t = fromSeconds(5 + 0.5 * o.interval_s);
  EXPECT_FALSE(pace.wants(e, true));  // moved, but just now
  EXPECT_TRUE(pace.wants(e, false));  // a run that is looked for
  e.state.t = fromSeconds(5 + 1.1 * o.interval_s);
  EXPECT_TRUE(pace.wants(e, true));
  e.state.T_W_B.p.setZero();
  EXPECT_FALSE(pace.wants(e, true));  // it stands
  e.segment = 1;
  EXPECT_TRUE(pace.wants(e, true));
  e.state.t = fromSeconds(4);
  EXPECT_FALSE(pace.wants(e, true));  // a clock that was set back
  EXPECT_TRUE(pace.searches(false));
  e.state.t = fromSeconds(5.1 + KeyframePace::kSearch_s);
  pace.took(e);
  EXPECT_FALSE(pace.searches(false));
}

/// The map of one run; the next begins elsewhere, turned, and goes on in the map's frame.
TEST(LoopCloser, ARunIsFoundInAMap) {
  Robot first, second;
  LoopCloser before({}, cameraOf());
  first.visit(&before, Pose(), 0, 0.01);
  before.solve({});
  const MissionMap map = decode(encode(before.map(cameraOf(), {})));
  ASSERT_EQ(map.keyframes.size(), static_cast<std::size_t>(kVisit));

  const Pose elsewhere(Quat(rotZ(-1.3)), Vec3(20, 5, -1));
  LoopCloser after({}, cameraOf());
  after.begin(map);
  EXPECT_FALSE(after.found());
  const Pose last = second.visit(&after, elsewhere, 0.2, 0.01, 0.2);
  ASSERT_TRUE(after.found());
  EXPECT_LT((last.p - onTheWay(kVisit - 1, 0.2).p).norm(), 0.05);
  after.solve({});
  const MissionMap extended = after.map(cameraOf(), {});
  EXPECT_EQ(extended.keyframes.size(), 2u * kVisit);
  EXPECT_EQ(extended.keyframes.front()->T_W_B.p, map.keyframes.front()->T_W_B.p);
  EXPECT_NE(extended.keyframes.front()->segment, extended.keyframes.back()->segment);

  // Found by itself it is a map too, and the two can be joined.
  LoopCloser alone({}, cameraOf());
  Robot third;
  third.visit(&alone, elsewhere, 0.2, 0.01, 0.2);
  const MergedMaps merged = merge(map, alone.map(cameraOf(), {}), {});
  EXPECT_EQ(merged.map.keyframes.size(), 2u * kVisit);
  EXPECT_LT((merged.map.keyframes.back()->T_W_B.p - onTheWay(kVisit - 1, 0.2).p).norm(), 0.1);
}

/// A map that is extended again and again stays as large as the setting allows. What goes are
/// second looks from where others look, old and new: the whole way stays covered.
TEST(LoopCloser, AMapIsBoundedByWhatIsRedundant) {
  LoopOptions few;
  few.index.max_keyframes = 20;
  MissionMap map;
  for (int run = 0; run < 4; ++run) {
    Robot robot;
    LoopCloser closer(few, cameraOf());
    if (run > 0) closer.begin(map);
    robot.visit(&closer, run == 0 ? Pose() : Pose(Quat(rotZ(0.5)), Vec3(run, 5, 0)), 100.0 * run,
                0.01, 0.02 * run);
    EXPECT_TRUE(closer.found()) << run;
    closer.solve({}, true);
    map = closer.map(cameraOf(), {});
    ASSERT_LE(map.keyframes.size(), 20u) << run;
    ASSERT_GE(map.keyframes.size(), 14u) << run;
    for (int k = 0; k < kVisit; ++k) {
      double nearest = 100;
      for (const auto& kept : map.keyframes) {
        nearest = std::min(nearest, (kept->T_W_B.p - onTheWay(k).p).norm());
      }
      EXPECT_LT(nearest, 0.7) << "run " << run << ", " << k;
    }
    int of_the_first = 0;
    for (const auto& kept : map.keyframes) of_the_first += kept->segment == 0 ? 1 : 0;
    EXPECT_GE(of_the_first, 4) << run << ": the oldest are not what goes";
  }
}

/// Anchors that map and run know: they fit, and the run is found; they contradict, and it is not.
TEST(LoopCloser, AnchorsOfAMapHaveASay) {
  const auto anchorAt = [](std::uint64_t id, const Vec3& p) {
    Anchor a;
    a.id = id;
    a.has_position = true;
    a.p_W = p;
    a.covariance = 0.01 * Mat3::Identity();
    a.state = AnchorState::estimated;
    return a;
  };
  const Vec3 first(-4, 3, 2), second(4, 2, 1);
  Robot before_robot;
  LoopCloser before({}, cameraOf());
  before_robot.visit(&before, Pose(), 0, 0.01);
  before.solve({});
  const MissionMap map = before.map(cameraOf(), {anchorAt(1, first), anchorAt(2, second)});
  const Pose elsewhere(Quat(rotZ(-1.3)), Vec3(20, 5, -1));
  for (const double off : {0.0, 5.0}) {
    for (const bool both : {false, true}) {
      Robot robot;
      LoopCloser after({}, cameraOf());
      after.begin(map);
      std::vector<Anchor> known{anchorAt(1, elsewhere * first + Vec3(off, 0, 0))};
      if (both) known.push_back(anchorAt(2, elsewhere * second + Vec3(off, 0, 0)));
      after.setAnchors(known);
      robot.visit(&after, elsewhere, 0.2, 0.01, 0.2);
      EXPECT_EQ(after.found(), off == 0) << off << both;
      if (!after.found()) continue;
      // The extended map knows it no worse than the map did; it was replaced by the run's once.
      Anchor worse = anchorAt(1, first + Vec3(0.1, 0, 0));
      worse.covariance *= 4;
      const MissionMap extended = after.map(cameraOf(), {worse});
      ASSERT_EQ(extended.anchors.size(), 2u);
      EXPECT_LE(extended.anchors[0].covariance.trace(), 0.03 + 1e-12);
      EXPECT_LT((extended.anchors[0].p_W - first).norm(), 0.01);
    }
  }
}

TEST(LoopCloser, AMapOfAnotherPlaceOrCamera) {
  Robot here(3), there(4);
  LoopCloser before({}, cameraOf());
  there.visit(&before, Pose(), 0, 0.01);
  const MissionMap map = before.map(cameraOf(), {});
  LoopCloser after({}, cameraOf());
  after.begin(map);
  here.visit(&after, Pose(), 0, 0.01);
  EXPECT_FALSE(after.found());
  EXPECT_EQ(after.map(cameraOf(), {}).keyframes.size(), static_cast<std::size_t>(kVisit));
  LoopCloser alone({}, cameraOf());
  here.visit(&alone, Pose(), 0, 0.01);
  EXPECT_THROW(merge(map, alone.map(cameraOf(), {}), {}), std::runtime_error);

  Calibration other = cameraOf();
  other.camera.fx *= 1.2;
  LoopCloser wrong({}, other);
  EXPECT_THROW(wrong.begin(map), std::invalid_argument);
  MissionMap empty;
  empty.calibration = cameraOf();
  EXPECT_THROW(merge(map, empty, {}), std::runtime_error);
}

}  // namespace
}  // namespace vir::mission
