#include "vir/results/scene_file.h"

#include <gtest/gtest.h>
#include <mrpt/opengl/CEllipsoid3D.h>
#include <mrpt/opengl/CFrustum.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CPointCloud.h>
#include <mrpt/opengl/CSetOfLines.h>

#include <limits>

#include "vir/rawlog/mrpt_pose.h"
#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

SceneRobot robot() {
  SceneRobot r;
  r.name = "robot A";
  r.color = {10, 20, 30};
  r.T.p = Vec3(100, 0, 0);
  for (int i = 0; i < 5; ++i) r.path.push_back({i, Pose(Quat::Identity(), Vec3(i, 0, 0))});
  r.path[2].T_W_B.p.y() = std::numeric_limits<double>::quiet_NaN();
  Anchor anchor;
  anchor.id = 7;
  anchor.has_position = true;
  anchor.p_W = Vec3(1, 2, 3);
  anchor.covariance = Vec3(0, 1, 1e6).asDiagonal();  // exact, and not known at all
  r.anchors = {anchor, Anchor()};
  r.landmarks = {{1, Vec3(1, 1, 1)}, {2, Vec3::Constant(INFINITY)}, {3, Vec3(2, 2, 2)}};
  return r;
}

TEST(SceneFile, HoldsWhatIsFinite) {
  const test::TempFolder folder;
  const std::string file = (folder / "scene.3Dscene").string();
  writeScene(file, {robot()});
  mrpt::opengl::COpenGLScene scene;
  ASSERT_TRUE(scene.loadFromFile(file));
  const auto lines = scene.getByClass<mrpt::opengl::CSetOfLines>();
  ASSERT_TRUE(lines);
  EXPECT_EQ(lines->size(), 3u);
  const auto points = scene.getByClass<mrpt::opengl::CPointCloud>();
  ASSERT_TRUE(points);
  EXPECT_EQ(points->size(), 2u);
  const auto ellipsoid = scene.getByClass<mrpt::opengl::CEllipsoid3D>();
  ASSERT_TRUE(ellipsoid);
  EXPECT_EQ(ellipsoid->getName(), "anchor 7");
  EXPECT_NEAR(ellipsoid->getPoseX(), 101, 1e-6);
  EXPECT_TRUE(scene.getByName("robot A"));
}

TEST(SceneFile, TruthAndCameras) {
  const test::TempFolder folder;
  const std::string file = (folder / "scene.3Dscene").string();
  SceneRobot r = robot();
  r.truth = {{0, Pose()}, {1, Pose(Quat::Identity(), Vec3(0, 1, 0))}};
  r.camera.emplace();
  r.camera->camera.fx = r.camera->camera.fy = 320;
  r.camera->camera.width = 640;
  r.camera->camera.height = 480;
  r.camera->T_B_C.p = Vec3(0, 0, 0.1);  // looks up: its z is the body's
  writeScene(file, {r});
  mrpt::opengl::COpenGLScene scene;
  ASSERT_TRUE(scene.loadFromFile(file));
  const auto truth = scene.getByClass<mrpt::opengl::CSetOfLines>(1);
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->size(), 1u);
  const auto frustum = scene.getByClass<mrpt::opengl::CFrustum>();
  ASSERT_TRUE(frustum);
  EXPECT_NEAR(frustum->getHorzFOV(), 90, 1e-3);
  const Vec3 ahead =
      rawlog::fromMrptPose(mrpt::poses::CPose3D(frustum->getPose())).q * Vec3::UnitX();
  EXPECT_NEAR((ahead - Vec3::UnitZ()).norm(), 0, 1e-6);
  EXPECT_FALSE(scene.getByClass<mrpt::opengl::CFrustum>(4)) << "one per finite pose";
  EXPECT_TRUE(scene.getByClass<mrpt::opengl::CFrustum>(3));
}

TEST(SceneFile, TheSameBytesAgain) {
  const test::TempFolder folder;
  for (const char* name : {"a.3Dscene", "b.3Dscene"}) {
    writeScene((folder / name).string(), {robot(), robot()});
  }
  EXPECT_EQ(test::readText(folder / "a.3Dscene"), test::readText(folder / "b.3Dscene"));
}

TEST(SceneFile, SaysWhichFileCannotBeWritten) {
  try {
    writeScene("/no/such/folder/scene.3Dscene", {robot()});
    FAIL() << "accepted";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("/no/such/folder"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace vir::results
