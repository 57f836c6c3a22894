/// Lines of sight, and places made up around paths.
#include "vir/rendering/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "made_scenes.h"
#include "vir/rendering/make_scene.h"

namespace {

using namespace vir;

TEST(Scene, MeasuresWhatIsInTheWay) {
  const vir::rendering::Scene scene(vir_test::room(), vir_test::crates());
  // Straight through the first crate, which is 0.8 m deep.
  EXPECT_NEAR(scene.solidBetween(Vec3(0, 0, 0), Vec3(7, 0, 0)), 0.8, 1e-12);
  EXPECT_NEAR(scene.solidBetween(Vec3(7, 0, 0), Vec3(0, 0, 0)), 0.8, 1e-12);
  // Slanted: the line y = (x - 3) / 2 is inside from x = 3 to 3.8.
  EXPECT_NEAR(scene.solidBetween(Vec3(1, -1, 0), Vec3(5, 1, 0)), 0.8 * std::sqrt(1 + 0.25), 1e-12);
  // Ends inside.
  EXPECT_NEAR(scene.solidBetween(Vec3(0, 0, 0), Vec3(3.3, 0, 0)), 0.3, 1e-12);
  EXPECT_EQ(scene.solidBetween(Vec3(0, 0, 1), Vec3(7, 0, 1)), 0);
  EXPECT_EQ(scene.solidBetween(Vec3(0, 0, 0), Vec3(0, 0, 0)), 0);
}

TEST(Scene, HidesWhatIsBehindButNotTheSurfaceItself) {
  const vir::rendering::Scene scene(vir_test::room(), vir_test::crates());
  EXPECT_TRUE(scene.hidden(Vec3(0, 0, 0), Vec3(5, 0, 0)));
  EXPECT_TRUE(scene.hidden(Vec3(0, 0, 0), Vec3(3.8, 0, 0)));   // the far side of the crate
  EXPECT_FALSE(scene.hidden(Vec3(0, 0, 0), Vec3(3.0, 0, 0)));  // the near side
  EXPECT_FALSE(scene.hidden(Vec3(0, 0, 0), Vec3(8, -3, 0)));   // a wall of the room
  EXPECT_TRUE(scene.hidden(Vec3(0, 0, 0), Vec3(9, -3, 0)));    // behind it
}

TEST(Scene, RefusesBoxesWithoutInside) {
  const vir::rendering::Box flat{Vec3(0, 0, 0), Vec3(1, 1, 0)};
  EXPECT_THROW(vir::rendering::Scene(flat, {}), std::invalid_argument);
  EXPECT_THROW(vir::rendering::Scene(vir_test::room(), {flat}), std::invalid_argument);
  vir::rendering::Box odd = vir_test::room();
  odd.high.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(vir::rendering::Scene(odd, {}), std::invalid_argument);
}

std::vector<Vec3> path() {
  std::vector<Vec3> out;
  for (int k = 0; k <= 40; ++k) out.emplace_back(0.25 * k, 0, 0.5);
  for (int k = 0; k <= 20; ++k) out.emplace_back(10, 0.25 * k, 0.5);
  return out;
}

bool same(const vir::rendering::Scene& a, const vir::rendering::Scene& b) {
  return std::equal(a.boxes().begin(), a.boxes().end(), b.boxes().begin(), b.boxes().end(),
                    [](const vir::rendering::Box& x, const vir::rendering::Box& y) {
                      return x.low == y.low && x.high == y.high;
                    });
}

TEST(MadeScene, LeavesThePathAndTheAnchorsFree) {
  for (const char* layout : {"room", "corridors"}) {
    vir::rendering::SceneOptions o;
    o.layout = layout;
    o.boxes = 80;
    const std::vector<Vec3> anchors{Vec3(3, 3, 2), Vec3(-2, -2, 0)};
    const vir::rendering::Scene scene = vir::rendering::makeScene(o, path(), anchors);
    EXPECT_GT(scene.boxes().size(), 40u) << layout;
    for (const vir::rendering::Box& b : scene.boxes()) {
      for (const Vec3& p : path()) EXPECT_FALSE(b.holds(p, 0.2)) << layout;
      for (const Vec3& a : anchors) EXPECT_FALSE(b.holds(a)) << layout;
    }
    for (const Vec3& p : path()) EXPECT_TRUE(scene.interior().holds(p, -1.0)) << layout;
    for (const Vec3& a : anchors) EXPECT_TRUE(scene.interior().holds(a)) << layout;
    EXPECT_TRUE(same(scene, vir::rendering::makeScene(o, path(), anchors))) << layout;
    o.seed = 2;
    EXPECT_FALSE(same(scene, vir::rendering::makeScene(o, path(), anchors))) << layout;
  }
}

TEST(MadeScene, CorridorsAreSolidAroundTheCorner) {
  vir::rendering::SceneOptions o;
  o.layout = "corridors";
  o.boxes = 0;
  const vir::rendering::Scene scene = vir::rendering::makeScene(o, path(), {});
  // Along a leg of the path there is sight, across the corner none.
  EXPECT_FALSE(scene.hidden(Vec3(0, 0, 0.5), Vec3(9, 0, 0.5)));
  EXPECT_TRUE(scene.hidden(Vec3(0, 0, 0.5), Vec3(10, 5, 0.5)));
  o.layout = "room";
  EXPECT_FALSE(vir::rendering::makeScene(o, path(), {}).hidden(Vec3(0, 0, 0.5), Vec3(10, 5, 0.5)));
}

TEST(MadeScene, SaysWhatIsWrong) {
  vir::rendering::SceneOptions o;
  EXPECT_THROW(vir::rendering::makeScene(o, {}, {}), std::invalid_argument);
  o.layout = "castle";
  EXPECT_THROW(vir::rendering::makeScene(o, path(), {}), std::invalid_argument);
}

}  // namespace
