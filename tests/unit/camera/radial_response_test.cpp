/// How pixels answer to the lens: against cameras whose coefficients really are others.
#include "vir/camera/radial_response.h"

#include <gtest/gtest.h>

#include "vir/camera/camera_model.h"
#include "vir/types/calibration_change.h"

namespace vir::camera {
namespace {

CameraCalibration lens(Distortion distortion, const std::array<double, 8>& dist) {
  CameraCalibration c{752, 480, 458, 457, 367, 248, distortion, dist};
  if (distortion == Distortion::double_sphere) c.fx = c.fy = 300;
  if (distortion == Distortion::omni) c.fx = c.fy = 800;
  return c;
}

TEST(RadialResponse, IsHowFarPixelsMove) {
  for (const CameraCalibration& c :
       {lens(Distortion::none, {}), lens(Distortion::radtan, {-0.28, 0.07, 2e-4, 2e-5}),
        lens(Distortion::equidistant, {-0.02, 0.03, -0.01, 0.002}),
        lens(Distortion::rational, {0.2, 0.1, 1e-4, 1e-4, 0.01, 0.3, 0.12, 0.02}),
        lens(Distortion::double_sphere, {-0.2, 0.55}),
        lens(Distortion::omni, {0.9, -0.1, 0.02, 1e-4, -2e-4})}) {
    const RadialResponse response(c);
    const auto camera = makeCamera(c);
    for (const Vec2& px : {Vec2(20, 30), Vec2(367, 20), Vec2(500, 300), Vec2(740, 250)}) {
      Vec3 bearing;
      ASSERT_TRUE(camera->unproject(px, &bearing));
      const Vec2 off = px - Vec2(c.cx, c.cy);
      for (int j = 0; j < 2; ++j) {
        constexpr double kChange = 1e-3;
        Vec2 moved;
        ASSERT_TRUE(
            makeCamera(withRadialChange(c, kChange * Vec2::Unit(j)))->project(bearing, &moved));
        const Vec2 said = kChange * response.at(off)[j] * off;
        EXPECT_LT((moved - px - said).norm(), 0.02 + 0.03 * (moved - px).norm())
            << static_cast<int>(c.distortion) << " " << j << " at " << px.transpose() << ": "
            << (moved - px).transpose() << " said " << said.transpose();
      }
    }
  }
}

TEST(RadialResponse, NothingAnswersWithoutACamera) {
  EXPECT_EQ(RadialResponse().at(Vec2(100, 50)), Vec2(0, 0));
}

TEST(RadialResponse, ACameraThatIsNoneIsRefused) {
  CameraCalibration c = lens(Distortion::radtan, {});
  c.fx = -1;
  EXPECT_THROW(RadialResponse{c}, std::invalid_argument);
}

}  // namespace
}  // namespace vir::camera
