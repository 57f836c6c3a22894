#include "vir/results/scene_file.h"

#include <Eigen/Dense>
//
#include <mrpt/opengl/CEllipsoid3D.h>
#include <mrpt/opengl/CFrustum.h>
#include <mrpt/opengl/CGridPlaneXY.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CPointCloud.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/opengl/stock_objects.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <type_traits>

#include "vir/core/angles.h"
#include "vir/geometry/finite_pose.h"
#include "vir/rawlog/mrpt_pose.h"

namespace vir::results {
namespace {

using namespace mrpt::opengl;

constexpr double kSmallest = 0.01, kLargest = 5;  // [m], half axes of an ellipsoid
constexpr double kSigmas = 2;
constexpr std::size_t kCameras = 30;
constexpr evaluation::Color kTruth{110, 110, 110}, kLoop{200, 60, 160};
constexpr std::size_t kMostPoints = 20000;  // of a path

/// Limits of what is shown.
struct Extent {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool empty() const { return !(low.x() <= high.x()); }
};

float f(double v) { return static_cast<float>(v); }

template <typename Shape>
void paint(Shape* shape, const evaluation::Color& c, std::uint8_t opacity = 255) {
  shape->setColor_u8(static_cast<std::uint8_t>(c.r), static_cast<std::uint8_t>(c.g),
                     static_cast<std::uint8_t>(c.b), opacity);
}

CSetOfLines::Ptr linesOf(const Trajectory& path, const Pose& T, const evaluation::Color& color,
                         Extent* extent) {
  auto lines = CSetOfLines::Create();
  paint(lines.get(), color);
  lines->setLineWidth(2.0F);
  const std::size_t every = path.size() / kMostPoints + 1;
  bool begun = false;
  Vec3 before = Vec3::Zero();
  for (std::size_t i = 0; i < path.size(); i += every) {
    const Vec3 p = T * path[i].T_W_B.p;
    if (!p.allFinite()) continue;
    if (begun) {
      lines->appendLine(f(before.x()), f(before.y()), f(before.z()), f(p.x()), f(p.y()), f(p.z()));
    }
    extent->add(p);
    before = p;
    begun = true;
  }
  return lines;
}

/// Where the camera looked, now and then.
void insertCameras(const SceneRobot& robot, CSetOfObjects* group) {
  const CameraCalibration& c = robot.camera->camera;
  if (c.fx <= 0 || c.fy <= 0 || c.width <= 0) return;
  const double across = 2 * std::atan(c.width / (2 * c.fx)),
               up = 2 * std::atan(c.height / (2 * c.fy));
  Mat3 R_C_F;  // a frustum looks along its x
  R_C_F << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Pose T_B_F = robot.camera->T_B_C * Pose(Quat(R_C_F), Vec3::Zero());
  for (std::size_t i = 0; i < robot.path.size(); i += robot.path.size() / kCameras + 1) {
    const Pose& T_W_B = robot.path[i].T_W_B;
    if (!isFinite(T_W_B)) continue;
    auto frustum = std::make_shared<CFrustum>(0.02F, 0.25F, f(kDegPerRad * across),
                                              f(kDegPerRad * up), 1.0F, true, false);
    frustum->setColor_u8(static_cast<std::uint8_t>(robot.color.r),
                         static_cast<std::uint8_t>(robot.color.g),
                         static_cast<std::uint8_t>(robot.color.b), 160);
    frustum->setPose(rawlog::toMrptPose(robot.T * T_W_B * T_B_F));
    group->insert(frustum);
  }
}

CPointCloud::Ptr pointsOf(const SceneRobot& robot) {
  auto points = CPointCloud::Create();
  paint(points.get(), robot.color, 150);
  points->setPointSize(4.0F);
  for (const Landmark& l : robot.landmarks) {
    const Vec3 p = robot.T * l.p_W;
    if (p.allFinite()) points->insertPoint(f(p.x()), f(p.y()), f(p.z()));
  }
  return points;
}

/// With half axes that can be seen and do not hide everything.
Mat3 shown(const Mat3& covariance) {
  if (!covariance.allFinite()) return Mat3::Identity() * kSmallest * kSmallest;
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance);
  const Vec3 half = (kSigmas * eigen.eigenvalues().cwiseMax(0).cwiseSqrt())
                        .cwiseMax(kSmallest)
                        .cwiseMin(kLargest) /
                    kSigmas;
  return eigen.eigenvectors() * half.cwiseAbs2().asDiagonal() * eigen.eigenvectors().transpose();
}

CEllipsoid3D::Ptr ellipsoidOf(const Anchor& anchor, const SceneRobot& robot) {
  auto ellipsoid = CEllipsoid3D::Create();
  const Mat3 R = robot.T.R();
  const Mat3 C = shown(R * anchor.covariance * R.transpose());
  std::decay_t<decltype(ellipsoid->getCovMatrix())> covariance;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) covariance(r, c) = f(C(r, c));
  }
  ellipsoid->setCovMatrix(covariance);
  ellipsoid->setQuantiles(static_cast<float>(kSigmas));
  paint(ellipsoid.get(), robot.color);
  const Vec3 p = robot.T * anchor.p_W;
  ellipsoid->setLocation(p.x(), p.y(), p.z());
  ellipsoid->setName("anchor " + std::to_string(anchor.id));
  ellipsoid->enableShowName(true);
  return ellipsoid;
}

CSetOfObjects::Ptr groupOf(const SceneRobot& robot, Extent* extent) {
  auto group = CSetOfObjects::Create();
  group->insert(linesOf(robot.path, robot.T, robot.color, extent));
  if (!robot.truth.empty()) group->insert(linesOf(robot.truth, robot.T, kTruth, extent));
  for (const LoopRecord& l : robot.loops) {
    if (!l.accepted) continue;
    const Trajectory both{{l.t_older, {Quat::Identity(), l.p_older}},
                          {l.t_newer, {Quat::Identity(), l.p_newer}}};
    group->insert(linesOf(both, robot.T, kLoop, extent));
  }
  if (robot.camera) insertCameras(robot, group.get());
  group->insert(pointsOf(robot));
  auto origin = stock_objects::CornerXYZSimple(0.5F, 2.0F);
  const Vec3& p = robot.T.p;
  origin->setLocation(p.x(), p.y(), p.z());
  if (!robot.name.empty()) {
    origin->setName(robot.name);
    origin->enableShowName(true);
  }
  group->insert(origin);
  for (const Anchor& a : robot.anchors) {
    if (!a.has_position || !a.p_W.allFinite()) continue;
    group->insert(ellipsoidOf(a, robot));
    extent->add(robot.T * a.p_W);
  }
  return group;
}

}  // namespace

void writeScene(const std::string& file, const std::vector<SceneRobot>& robots) {
  COpenGLScene scene;
  Extent extent;
  for (const SceneRobot& robot : robots) scene.insert(groupOf(robot, &extent));
  if (!extent.empty()) {
    const Vec3 low = extent.low.array().floor() - 1, high = extent.high.array().ceil() + 1;
    auto grid = CGridPlaneXY::Create(f(low.x()), f(high.x()), f(low.y()), f(high.y()),
                                     f(std::min(0.0, extent.low.z())), 1.0F);
    grid->setColor(0.4F, 0.4F, 0.4F);
    scene.insert(grid);
  }
  const std::string part = file + ".part";
  bool written = false;
  try {
    // Read back, since MRPT does not notice a disk that becomes full with the last bytes.
    written = scene.saveToFile(part) && COpenGLScene().loadFromFile(part);
  } catch (const std::exception&) {  // its text is a backtrace
  }
  std::error_code error;
  if (written) std::filesystem::rename(part, file, error);
  if (!written || error) {
    std::filesystem::remove(part, error);
    throw std::runtime_error("cannot write " + file);
  }
}

}  // namespace vir::results
