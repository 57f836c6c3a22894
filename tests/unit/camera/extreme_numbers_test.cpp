/// Numbers that are no measurements: an exception, or an answer of numbers.
#include <gtest/gtest.h>

#include <stdexcept>

#include "vir/camera/camera_model.h"
#include "vir/camera/radial_response.h"
#include "vir_test_extremes.h"

namespace vir::camera {
namespace {

const Distortion kModels[] = {Distortion::none,          Distortion::radtan,
                              Distortion::equidistant,   Distortion::rational,
                              Distortion::double_sphere, Distortion::omni};

CameraCalibration usual(Distortion distortion) {
  CameraCalibration c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 400;
  c.cx = 320;
  c.cy = 240;
  c.distortion = distortion;
  if (distortion == Distortion::double_sphere) c.dist = {-0.2, 0.6};
  return c;
}

void expectNumbers(const CameraModel& camera, const Vec3& p_C) {
  Vec2 px = Vec2::Zero();
  Mat23 J = Mat23::Zero();
  const bool seen = camera.project(p_C, &px, &J);
  EXPECT_TRUE(px.allFinite()) << p_C.transpose();
  EXPECT_TRUE(!seen || J.allFinite()) << p_C.transpose();
}

void expectNumbers(const CameraModel& camera, const Vec2& px) {
  Vec3 bearing = Vec3::UnitZ();
  if (!camera.unproject(px, &bearing)) return;
  EXPECT_NEAR(bearing.norm(), 1, 1e-6) << px.transpose();
}

TEST(ExtremeNumbers, PointsAndPixels) {
  for (const Distortion distortion : kModels) {
    SCOPED_TRACE(static_cast<int>(distortion));
    const auto camera = makeCamera(usual(distortion));
    test::forExtremeVectors(Vec3(0.1, 0.2, 1), [&](const Vec3& p) {
      expectNumbers(*camera, p);
      expectNumbers(*camera, Vec2(p.head<2>()));
    });
  }
}

TEST(ExtremeNumbers, Calibrations) {
  for (const Distortion distortion : kModels) {
    for (std::size_t field = 0; field < 12; ++field) {
      for (const double x : test::extremes()) {
        SCOPED_TRACE(testing::Message() << "model " << static_cast<int>(distortion) << ", field "
                                        << field << " = " << x);
        CameraCalibration c = usual(distortion);
        double* const fields[] = {&c.fx, &c.fy, &c.cx, &c.cy};
        (field < 4 ? *fields[field] : c.dist[field - 4]) = x;
        try {
          const auto camera = makeCamera(c);
          for (const Vec3& p : {Vec3(0.1, 0.2, 1), Vec3(0, 0, 1), Vec3(-2, 1, 0.5)}) {
            expectNumbers(*camera, p);
          }
          for (const Vec2& px : {Vec2(0, 0), Vec2(320, 240), Vec2(639, 100)}) {
            expectNumbers(*camera, px);
          }
          EXPECT_TRUE(RadialResponse(c).at(Vec2(100, 50)).allFinite());
        } catch (const std::invalid_argument&) {
        }
      }
    }
  }
}

}  // namespace
}  // namespace vir::camera
