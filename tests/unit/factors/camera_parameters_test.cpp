/// How a bearing moves with the camera's parameters: against cameras that really have them.
#include "vir/factors/camera_parameters.h"

#include <gtest/gtest.h>

#include "vir/camera/camera_model.h"
#include "vir/camera/radial_response.h"
#include "vir/types/calibration_change.h"

namespace vir::factors {
namespace {

CameraCalibration fisheye() {
  CameraCalibration c;
  c.width = 752;
  c.height = 480;
  c.fx = 458;
  c.fy = 457;
  c.cx = 367;
  c.cy = 248;
  c.distortion = Distortion::equidistant;
  c.dist = {-0.02, 0.03, -0.01, 0.002, 0};
  return c;
}

CameraCalibration radtan() {
  CameraCalibration c = fisheye();
  c.distortion = Distortion::radtan;
  c.dist = {-0.28, 0.07, 0.0002, 0.00002, 0};
  return c;
}

Vec3 bearingIn(const CameraCalibration& c, const Vec2& px) {
  Vec3 b;
  EXPECT_TRUE(camera::makeCamera(c)->unproject(px, &b));
  return b;
}

CameraCalibration changed(CameraCalibration c, const CameraVector& by) {
  c.fx *= 1 + by[kFocal] + by[kAspect];
  c.fy *= 1 + by[kFocal] - by[kAspect];
  c.cx += by[kCx];
  c.cy += by[kCy];
  return withRadialChange(c, by.segment<2>(kRadial1));
}

TEST(BearingByCamera, IsWhatACameraWithOtherIntrinsicsSees) {
  for (const CameraCalibration& c : {fisheye(), radtan()}) {
    const camera::RadialResponse radial(c);
    for (const Vec2& px : {Vec2(100, 60), Vec2(367, 248), Vec2(700, 400), Vec2(380, 20)}) {
      const Vec3 b = bearingIn(c, px);
      Vec2 again;
      Mat23 J;
      ASSERT_TRUE(camera::makeCamera(c)->project(b, &again, &J));
      const Vec2 centre(c.cx, c.cy);
      const CameraJacobian D =
          bearingByCamera(px, J, Vec3::Zero(), centre, 0, radial.at(px - centre));
      for (const int k : {kFocal, kAspect, kCx, kCy, kRadial1, kRadial2}) {
        const double h = k == kCx || k == kCy ? 0.05 : 1e-4;
        CameraVector step = CameraVector::Zero();
        step[k] = h;
        const Vec3 numeric =
            (bearingIn(changed(c, step), px) - bearingIn(changed(c, -step), px)) / (2 * h);
        // The response to the lens is a fit to the whole image.
        const double most = k == kRadial1 || k == kRadial2 ? 2e-2 * std::max(0.2, numeric.norm())
                                                           : 2e-5 * std::max(1.0, numeric.norm());
        EXPECT_LT((D.col(k) - numeric).norm(), most) << k << " at " << px.transpose();
      }
    }
  }
}

TEST(BearingByCamera, ARowIsSeenAtItsOwnTime) {
  // Image height 480, row 360: a quarter of the readout after the middle. The bearing moves at
  // (0.2, 0.1, 0)/s: 20 ms later at the middle it was 0.2 * 0.02 further back.
  const Vec3 rate(0.2, 0.1, 0);
  Mat23 J;
  J << 400, 0, 0, 0, 400, 0;
  const CameraJacobian D =
      bearingByCamera(Vec2(320, 360), J, rate, Vec2(320, 240), 0.25, Vec2::Zero());
  EXPECT_LT((D.col(kTimeOffset) + rate).norm(), 1e-15);
  EXPECT_LT((D.col(kReadout) + 0.25 * rate).norm(), 1e-15);
  CameraRay ray;
  ray.by_camera = D;
  ray.at[kTimeOffset] = 0.01;
  CameraVector c = CameraVector::Zero();
  c[kTimeOffset] = 0.01;
  EXPECT_EQ(ray.bearingAt(c), ray.bearing);
  c[kTimeOffset] = 0.03;
  c[kReadout] = 0.02;
  EXPECT_LT((ray.bearingAt(c) - ray.bearing + rate * (0.02 + 0.25 * 0.02)).norm(), 1e-15);
}

}  // namespace
}  // namespace vir::factors
