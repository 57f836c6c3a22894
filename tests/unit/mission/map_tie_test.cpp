/// Two robots in one room, each in a world of its own: what both saw ties the worlds.
#include "vir/mission/map_tie.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "rendered_places.h"
#include "vir/rendering/make_scene.h"

namespace vir::mission {
namespace {

using vir_test::bodyAt;
using vir_test::cameraInBody;
using vir_test::PlaceMaker;

constexpr int kVisit = 14;

Pose onTheWay(int k, double aside) {
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
  for (int k = 0; k < kVisit; ++k) way.push_back(onTheWay(k, 0).p);
  return std::make_shared<rendering::Scene>(rendering::makeScene(o, way, {}));
}

/// A robot's map, in a world where the room lies at T_W_room.
struct Visitor {
  Visitor(int scene, const LevelTransform& T_W_room, double aside, double begin_s)
      : maker(room(scene), cameraOf().camera, {}), aside_m(aside), begin(begin_s) {
    LoopCloser closer({}, cameraOf());
    for (int k = 0; k < kVisit; ++k) {
      const Pose truth = onTheWay(k, aside);
      const rendering::GrayImage image = maker.take(truth, begin + 0.5 * k);
      SeenKeyframe seen;
      seen.gray = viewOf(image);
      seen.landmarks = maker.seen(image, truth * cameraInBody());
      StateEstimate& e = seen.estimate;
      e.valid = e.keyframe = true;
      e.state.t = fromSeconds(1000 + begin + 0.5 * k);
      e.state.T_W_B = T_W_room.pose() * truth;
      e.covariance.diagonal() << Vec3::Constant(1e-4), Vec3::Constant(1e-4);
      closer.add(seen);
    }
    closer.solve({}, true);
    map = closer.map(cameraOf(), {});
  }
  static Image viewOf(const rendering::GrayImage& image) {
    Image out;
    out.width = image.width;
    out.height = image.height;
    out.pixels = image.pixels.data();
    return out;
  }
  ImageOfKeyframe images() {
    return [this](const PlaceKeyframe& k) -> std::optional<Image> {
      const double s = toSeconds(k.t) - 1000 - begin;
      kept = maker.take(onTheWay(static_cast<int>(std::lround(s / 0.5)), aside_m), begin + s);
      return viewOf(kept);
    };
  }

  PlaceMaker maker;
  double aside_m, begin;
  MissionMap map;
  rendering::GrayImage kept;
};

TEST(MapTie, LaysOneWorldIntoTheOther) {
  const LevelTransform T_B_room{-2.1, Vec3(12, -7, 3)};
  Visitor a(3, {}, 0, 0), b(3, T_B_room, 0.2, 60);
  const MapTie found = tie(a.map, b.map, b.images(), {});
  ASSERT_GE(found.shared.places, 2);
  EXPECT_GE(found.shared.images, found.shared.places);
  EXPECT_EQ(found.imageless, 0);
  EXPECT_EQ(found.looked, static_cast<long>(b.map.keyframes.size()));
  const LevelTransform truth = T_B_room.inverse();
  const Vec3 at = found.shared.centre_B;
  EXPECT_LT((found.shared.T_A_B * at - truth * at).norm(), 0.05);
  EXPECT_LT(std::abs(std::remainder(found.shared.T_A_B.yaw_rad - truth.yaw_rad, 2 * M_PI)), 0.01);
  Eigen::Vector4d e;
  e << std::remainder(found.shared.T_A_B.yaw_rad - truth.yaw_rad, 2 * M_PI),
      found.shared.T_A_B.t_m - truth.t_m;
  EXPECT_LT(e.dot(found.shared.covariance.ldlt().solve(e)), 18.5);  // 99.9 % of four
  EXPECT_GE(found.shared.since, b.map.keyframes.front()->t);
  EXPECT_LE(found.shared.until, b.map.keyframes.back()->t);
  EXPECT_LE(found.shared.since, found.shared.until);

  // The same input, the same numbers.
  const MapTie again = tie(a.map, b.map, b.images(), {});
  EXPECT_EQ(again.shared.T_A_B.yaw_rad, found.shared.T_A_B.yaw_rad);
  EXPECT_EQ(again.shared.covariance, found.shared.covariance);
}

TEST(MapTie, SaysNothingOfAnotherRoomNorWithoutImages) {
  Visitor a(3, {}, 0, 0), stranger(8, {}, 0.2, 60), b(3, {}, 0.2, 60);
  EXPECT_EQ(tie(a.map, stranger.map, stranger.images(), {}).shared.places, 0);
  const MapTie blind =
      tie(a.map, b.map, [](const PlaceKeyframe&) { return std::optional<Image>(); }, {});
  EXPECT_EQ(blind.shared.places, 0);
  EXPECT_EQ(blind.looked, 0);
  EXPECT_EQ(blind.imageless, static_cast<long>(b.map.keyframes.size()));
}

TEST(MapTie, RefusesWhatCannotBeCompared) {
  Visitor a(3, {}, 0, 0);
  MissionMap other = a.map, empty;
  other.calibration.camera.fx *= 1.2;
  EXPECT_THROW(tie(a.map, other, a.images(), {}), std::runtime_error);
  empty.calibration = cameraOf();
  EXPECT_THROW(tie(a.map, empty, a.images(), {}), std::runtime_error);
  EXPECT_THROW(tie(empty, a.map, a.images(), {}), std::runtime_error);
  LoopOptions options;
  options.graph.gate = -1;
  EXPECT_THROW(tie(a.map, a.map, a.images(), options), std::invalid_argument);
}

}  // namespace
}  // namespace vir::mission
