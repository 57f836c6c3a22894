#include "vir/check/intrinsics_check.h"

#include <gtest/gtest.h>

namespace vir::check {
namespace {

std::optional<Finding> of(double fx, double fy, double cx, double cy) {
  CameraCalibration c;
  c.width = 752, c.height = 480;
  c.fx = fx, c.fy = fy, c.cx = cx, c.cy = cy;
  return intrinsicsFinding(c, "CAM0");
}

TEST(IntrinsicsCheck, NamesNumbersThatNoCameraHas) {
  const auto normalised = of(0.61, 0.953, 0.488, 0.517);
  ASSERT_TRUE(normalised);
  EXPECT_EQ(normalised->severity, Severity::unusable);
  EXPECT_EQ(normalised->kind, "camera_intrinsics");
  EXPECT_NE(normalised->remedy.find("units of the image's width"), std::string::npos);
  EXPECT_NE(normalised->evidence.find("fx 0.61"), std::string::npos) << normalised->evidence;
  const auto no_point = of(458654, 457296, 367.215, 248.375);
  ASSERT_TRUE(no_point);
  EXPECT_NE(no_point->what.find("far too long"), std::string::npos) << no_point->what;
  const auto outside = of(458, 457, 367, 500);
  ASSERT_TRUE(outside);
  EXPECT_NE(outside->what.find("outside"), std::string::npos) << outside->what;
}

TEST(IntrinsicsCheck, LeavesFisheyesAndTelephotosAlone) {
  EXPECT_FALSE(of(458.654, 457.296, 367.215, 248.375));
  EXPECT_FALSE(of(110, 110, 376, 240));                          // a circle of 230 deg
  EXPECT_FALSE(of(14000, 14000, 376, 240));                      // 3 deg
  EXPECT_FALSE(intrinsicsFinding(CameraCalibration{}, "CAM0"));  // size not known
}

}  // namespace
}  // namespace vir::check
