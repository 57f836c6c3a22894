#include "vir/camera/camera_model.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace vir::camera {
namespace {

CameraCalibration calibration(Distortion kind, std::array<double, 8> dist) {
  CameraCalibration c;
  c.width = 752;
  c.height = 480;
  c.fx = 458.654;
  c.fy = 457.296;
  c.cx = 367.215;
  c.cy = 248.375;
  c.distortion = kind;
  c.dist = dist;
  return c;
}

struct Case {
  std::string name;
  CameraCalibration calibration;
};

std::vector<Case> cases() {
  CameraCalibration fisheye = calibration(
      Distortion::equidistant, {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673, 0.0});
  fisheye.width = fisheye.height = 512;
  fisheye.fx = fisheye.fy = 190.97;
  fisheye.cx = 254.93;
  fisheye.cy = 256.89;
  return {
      {"none", calibration(Distortion::none, {})},
      {"EuRoC",
       calibration(Distortion::radtan, {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0})},
      {"pincushion with k3", calibration(Distortion::radtan, {0.12, -0.03, -0.002, 0.003, 0.015})},
      {"strong tangential", calibration(Distortion::radtan, {-0.2, 0.05, 0.01, -0.02, 0.0})},
      {"rational", calibration(Distortion::rational,
                               {10.2, -120.5, 0.0003, -0.0005, 430.1, 10.0, -119.1, 426.0})},
      {"omni", calibration(Distortion::omni, {1.1, -0.1, 0.02, 0.001, -0.002})},
      {"omni within the sphere", calibration(Distortion::omni, {0.8, -0.05, 0.01, 0.001, 0.0005})},
      {"double sphere", calibration(Distortion::double_sphere, {-0.2, 0.59})},
      {"double sphere of positive xi", calibration(Distortion::double_sphere, {0.6, 0.45})},
      {"fisheye", fisheye},
      {"fisheye of pure angle", calibration(Distortion::equidistant, {})},
  };
}

std::vector<Vec3> points() {
  return {{0, 0, 1},       {0, 0, 7.5},          {1e-9, -1e-9, 1}, {1e-4, 0, 1},
          {9e-5, 3e-5, 1}, {1.1e-4, -2e-5, 1},   {0.3, -0.2, 1},   {-0.5, 0.4, 1.3},
          {2, 1.5, 6},     {-0.02, 0.015, 0.04}, {0.7, 0.45, 1.0}, {-300, 200, 900}};
}

TEST(CameraModel, ProjectsByHand) {
  const auto pinhole = makeCamera(calibration(Distortion::none, {}));
  Vec2 px;
  ASSERT_TRUE(pinhole->project(Vec3(0.2, -0.4, 2.0), &px));
  EXPECT_DOUBLE_EQ(px.x(), 458.654 * 0.1 + 367.215);
  EXPECT_DOUBLE_EQ(px.y(), 457.296 * -0.2 + 248.375);

  // x = 0.5, y = 0, r2 = 0.25: radial = 1 - 0.2 / 4 + 0.05 / 16 = 0.953125;
  // u = 0.5 * 0.953125 + p2 (0.25 + 0.5), v = p1 * 0.25.
  const auto radtan = makeCamera(calibration(Distortion::radtan, {-0.2, 0.05, 0.01, -0.02, 0.0}));
  ASSERT_TRUE(radtan->project(Vec3(1.0, 0.0, 2.0), &px));
  EXPECT_NEAR(px.x(), 458.654 * (0.4765625 - 0.015) + 367.215, 1e-12);
  EXPECT_NEAR(px.y(), 457.296 * 0.0025 + 248.375, 1e-12);

  // 45 deg to the right: the distance from the centre is pi/4 (1 + k1 pi^2/16).
  const auto fisheye = makeCamera(calibration(Distortion::equidistant, {0.01, 0, 0, 0, 0}));
  ASSERT_TRUE(fisheye->project(Vec3(3.0, 0.0, 3.0), &px));
  const double quarter = std::atan(1.0);
  EXPECT_NEAR(px.x(), 458.654 * quarter * (1 + 0.01 * quarter * quarter) + 367.215, 1e-12);
  EXPECT_NEAR(px.y(), 248.375, 1e-12);
}

/// The pixels are the published formulas of each model evaluated with 40 decimal digits.
TEST(CameraModel, AgreesWithThePublishedFormulas) {
  struct Known {
    Distortion kind;
    std::array<double, 8> dist;
    Vec3 p_C;
    Vec2 px;
  };
  const Vec3 near(0.3, -0.2, 1), behind(2, 1.5, -0.25);
  const std::array<double, 8> omni{1.6, -0.1, 0.02, 0.001, -0.002};
  const std::array<double, 8> inner{0.8, -0.05, 0.01, 0.001, 0.0005};
  const std::array<double, 8> rational{10.2, -120.5, 0.0003, -0.0005, 430.1, 10.0, -119.1, 426.0};
  const std::vector<Known> known{
      {Distortion::rational, rational, near, {506.00015627890804, 156.12352773568335}},
      {Distortion::omni, omni, near, {418.02401990228719, 214.59989495979548}},
      {Distortion::omni, omni, behind, {600.0508516634394, 422.98759007606139}},
      {Distortion::omni, inner, near, {441.43937687088606, 199.0617425309589}},
      {Distortion::omni, inner, behind, {859.00036718052797, 616.69864553716377}},
      {Distortion::double_sphere, {-0.2, 0.59}, near, {532.24083642366725, 138.68351884979771}},
      {Distortion::double_sphere, {-0.2, 0.59}, behind, {1111.8761506440164, 805.21724744290827}},
      {Distortion::double_sphere, {0.6, 0.55}, near, {450.13532482845648, 193.2584591903645}},
      {Distortion::double_sphere, {0.6, 0.55}, behind, {802.98913523988313, 574.23790910248943}}};
  for (const Known& k : known) {
    const auto camera = makeCamera(calibration(k.kind, k.dist));
    Vec2 px;
    Vec3 bearing;
    ASSERT_TRUE(camera->project(k.p_C, &px));
    EXPECT_LT((px - k.px).norm(), 1e-10) << px.transpose() << " not " << k.px.transpose();
    ASSERT_TRUE(camera->unproject(k.px, &bearing));
    EXPECT_LT((bearing - k.p_C.normalized()).norm(), 1e-12);
  }
}

/// OpenCV's own projection is the third opinion on radtan and rational.
TEST(CameraModel, AgreesWithOpenCv) {
  for (const Case& c : cases()) {
    const bool rational = c.calibration.distortion == Distortion::rational;
    if (!rational && c.calibration.distortion != Distortion::radtan) continue;
    const auto camera = makeCamera(c.calibration);
    const CameraCalibration& k = c.calibration;
    const cv::Matx33d K(k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1);
    const std::vector<double> dist(k.dist.begin(), k.dist.begin() + (rational ? 8 : 5));
    for (const Vec3& p : points()) {
      std::vector<cv::Point2d> out;
      const std::vector<cv::Point3d> in{{p.x(), p.y(), p.z()}};
      cv::projectPoints(in, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, dist, out);
      Vec2 px;
      ASSERT_TRUE(camera->project(p, &px));
      EXPECT_LT((px - Vec2(out[0].x, out[0].y)).norm(), 1e-9) << c.name;
    }
  }
}

TEST(CameraModel, SeesAsFarAsTheSpheresDo) {
  // alpha = 1/2 has w1 = 1: z > -(1 + xi) / sqrt(2 xi + xi^2 + 1) = -1, all but straight behind.
  const auto half = makeCamera(calibration(Distortion::double_sphere, {0.3, 0.5}));
  Vec2 px;
  EXPECT_TRUE(half->project(Vec3(0.3, 0, -1), &px));
  EXPECT_FALSE(half->project(Vec3(0, 0, -1), &px));
  // alpha = 0 and xi = 0 is a pinhole.
  const auto pinhole = makeCamera(calibration(Distortion::double_sphere, {0, 0}));
  EXPECT_TRUE(pinhole->project(Vec3(1, 0, 0.1), &px));
  EXPECT_FALSE(pinhole->project(Vec3(1, 0, -0.1), &px));
  // xi = 2: the ray from 2 behind the centre touches the sphere at z = -1/2.
  const auto omni = makeCamera(calibration(Distortion::omni, {2.0}));
  EXPECT_TRUE(omni->project(Vec3(std::sqrt(1 - 0.49 * 0.49), 0, -0.49), &px));
  EXPECT_FALSE(omni->project(Vec3(std::sqrt(1 - 0.51 * 0.51), 0, -0.51), &px));
}

TEST(CameraModel, JacobianMatchesCentralDifferences) {
  for (const Case& c : cases()) {
    const auto camera = makeCamera(c.calibration);
    for (const Vec3& p : points()) {
      SCOPED_TRACE(c.name + " at " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
                   std::to_string(p.z()));
      Vec2 px, plain;
      Mat23 J;
      ASSERT_TRUE(camera->project(p, &px, &J));
      ASSERT_TRUE(camera->project(p, &plain));
      EXPECT_EQ(px, plain) << "asking for the Jacobian changed the projection";
      const double h = 1e-6 * p.norm();
      Mat23 numeric;
      for (int k = 0; k < 3; ++k) {
        Vec2 plus, minus;
        ASSERT_TRUE(camera->project(p + h * Vec3::Unit(k), &plus));
        ASSERT_TRUE(camera->project(p - h * Vec3::Unit(k), &minus));
        numeric.col(k) = (plus - minus) / (2 * h);
      }
      EXPECT_LT((J - numeric).norm(), 2e-7 * J.norm()) << J << "\nnumeric\n" << numeric;
      // Only the direction of a point matters: J p = 0.
      EXPECT_LT((J * p).norm(), 1e-9);
    }
  }
}

TEST(CameraModel, UnprojectInvertsProjectOverTheWholeImage) {
  for (const Case& c : cases()) {
    const auto camera = makeCamera(c.calibration);
    int inside = 0, total = 0;
    for (int y = 0; y <= c.calibration.height; y += 12) {
      for (int x = 0; x <= c.calibration.width; x += 12) {
        const Vec2 px(x - 0.5, y - 0.5);
        Vec3 b;
        Vec2 again;
        ++total;
        if (!camera->unproject(px, &b)) continue;
        ++inside;
        EXPECT_NEAR(b.norm(), 1.0, 1e-14);
        ASSERT_TRUE(camera->project(b, &again)) << c.name << " " << px.transpose();
        EXPECT_LT((again - px).norm(), 1e-9) << c.name << " at " << px.transpose();
      }
    }
    EXPECT_EQ(inside, total) << c.name;
  }
}

TEST(CameraModel, UnprojectFindsTheBearing) {
  for (const Case& c : cases()) {
    const auto camera = makeCamera(c.calibration);
    for (const Vec3& p : points()) {
      Vec2 px;
      Vec3 b;
      ASSERT_TRUE(camera->project(p, &px));
      ASSERT_TRUE(camera->unproject(px, &b)) << c.name;
      EXPECT_LT((b - p.normalized()).norm(), 1e-13) << c.name;
    }
  }
}

TEST(CameraModel, RefusesWhatLiesBeyondTheTurningPoint) {
  // r (1 - 0.4 r^2) turns at r = 1 / sqrt(1.2) = 0.913, where it reaches 0.6086 (279 px).
  const auto camera = makeCamera(calibration(Distortion::radtan, {-0.4, 0, 0, 0, 0}));
  Vec2 px;
  Vec3 b;
  EXPECT_TRUE(camera->project(Vec3(0.912, 0, 1), &px));
  EXPECT_FALSE(camera->project(Vec3(0.914, 0, 1), &px));
  EXPECT_TRUE(px.allFinite());
  EXPECT_FALSE(camera->project(Vec3(5, 0, 1), &px));
  EXPECT_TRUE(camera->unproject(Vec2(367.215 + 279.0, 248.375), &b));
  EXPECT_FALSE(camera->unproject(Vec2(367.215 + 279.3, 248.375), &b));
  EXPECT_FALSE(camera->unproject(Vec2(0, 0), &b)) << "a corner of the image has no bearing here";
  EXPECT_TRUE(b.allFinite());

  // theta (1 - 0.2 theta^2) turns at theta = 1 / sqrt(0.6) = 1.291, where it reaches 0.8607.
  const auto fisheye = makeCamera(calibration(Distortion::equidistant, {-0.2, 0, 0, 0, 0}));
  EXPECT_TRUE(fisheye->project(Vec3(std::sin(1.28), 0, std::cos(1.28)), &px));
  EXPECT_FALSE(fisheye->project(Vec3(std::sin(1.30), 0, std::cos(1.30)), &px));
  EXPECT_FALSE(fisheye->unproject(Vec2(367.215 + 458.654 * 0.862, 248.375), &b));
}

TEST(CameraModel, SeesBehindTheImagePlaneOnlyWithAFisheye) {
  Vec2 px;
  EXPECT_TRUE(makeCamera(calibration(Distortion::equidistant, {}))->project(Vec3(1, 0, -0.1), &px));
  for (const Distortion kind : {Distortion::none, Distortion::radtan}) {
    const auto camera = makeCamera(calibration(kind, {}));
    EXPECT_FALSE(camera->project(Vec3(0.1, 0, -1), &px));
    EXPECT_FALSE(camera->project(Vec3(0.1, 0, 0), &px));
  }
}

TEST(CameraModel, IsFiniteForAnyInput) {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> odd = {0.0,  1e-320, -1e-320, 1e-160, 1e-30, 1.0,
                                   -1.0, 1e30,   1e200,   -1e308, inf,   nan};
  for (const Case& c : cases()) {
    const auto camera = makeCamera(c.calibration);
    for (double x : odd) {
      for (double y : odd) {
        Vec3 b;
        camera->unproject(Vec2(x, y), &b);
        EXPECT_TRUE(b.allFinite()) << c.name << " " << x << " " << y;
        for (double z : odd) {
          Vec2 px;
          Mat23 J;
          camera->project(Vec3(x, y, z), &px, &J);
          EXPECT_TRUE(px.allFinite() && J.allFinite())
              << c.name << " " << x << " " << y << " " << z;
        }
      }
    }
  }
}

TEST(CameraModel, RefusesImpossibleCalibrationsByName) {
  const CameraCalibration good = calibration(Distortion::radtan, {});
  const auto message = [](const CameraCalibration& c) -> std::string {
    try {
      makeCamera(c);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(good), "accepted");
  CameraCalibration bad = good;
  bad.width = 0;
  EXPECT_NE(message(bad).find("width = 0"), std::string::npos) << message(bad);
  bad = good;
  bad.fy = -1;
  EXPECT_NE(message(bad).find("fy = -1"), std::string::npos) << message(bad);
  bad = good;
  bad.cx = std::nan("");
  EXPECT_NE(message(bad).find("cx"), std::string::npos) << message(bad);
  bad = good;
  bad.distortion = Distortion::double_sphere;
  bad.dist[1] = 1.5;
  EXPECT_NE(message(bad).find("alpha = 1.5"), std::string::npos) << message(bad);
  bad = good;
  bad.dist[3] = std::numeric_limits<double>::infinity();
  EXPECT_NE(message(bad).find("coefficient 3"), std::string::npos) << message(bad);
}

/// theta + k2 theta^5 turns back where 1 + 5 k2 theta^4 = 0: nothing is seen beyond.
TEST(CameraModel, NothingIsSeenBeyondWhereTheLensTurnsBack) {
  const auto fisheye = makeCamera(calibration(Distortion::equidistant, {0, -0.02, 0, 0}));
  const double edge = std::pow(10.0, 0.25);
  for (const double theta : {edge - 0.01, edge + 0.01}) {
    Vec2 px;
    EXPECT_EQ(fisheye->project(Vec3(std::sin(theta), 0, std::cos(theta)), &px), theta < edge)
        << theta;
  }
}

}  // namespace
}  // namespace vir::camera
