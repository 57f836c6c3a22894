/// Numbers that are no measurements: from numbers come numbers, or an exception.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "vir/geometry/interpolation.h"
#include "vir/geometry/spline.h"
#include "vir_test_extremes.h"

namespace vir {
namespace {

TEST(ExtremeNumbers, Rotations) {
  test::forExtremeVectors(Vec3(0.1, -0.2, 0.3), [](const Vec3& v) {
    SCOPED_TRACE(testing::Message() << v.transpose());
    const Quat q = expQuat(v);
    if (!v.allFinite()) return;
    EXPECT_NEAR(q.norm(), 1, 1e-9);
    EXPECT_TRUE(logQuat(q).allFinite());
    EXPECT_TRUE(rightJacobianSO3(logQuat(q)).allFinite());
    EXPECT_TRUE(rightJacobianInverseSO3(logQuat(q)).allFinite());
    EXPECT_TRUE(interpolate(Pose(), Pose(q, Vec3::Zero()), 0.3).q.coeffs().allFinite());
  });
}

TEST(ExtremeNumbers, UpsOfAllLengths) {
  test::forExtremeVectors(Vec3(0.1, 0.2, 9.81), [](const Vec3& up) {
    try {
      const Quat q = gravityAlignedAttitude(up);
      EXPECT_TRUE(!up.allFinite() || std::abs(q.norm() - 1) < 1e-9) << up.transpose();
    } catch (const std::invalid_argument&) {
    }
  });
}

TEST(ExtremeNumbers, TimesOfASpline) {
  const VectorSpline spline =
      VectorSpline::through(0.5, {Vec3::Zero(), Vec3::Ones(), Vec3::Zero(), Vec3::Ones()});
  for (const double x : test::extremes()) {
    try {
      EXPECT_TRUE(spline.at(x).value.allFinite()) << x;
    } catch (const std::out_of_range&) {
    }
    try {
      const VectorSpline made =
          VectorSpline::through(x, {Vec3::Zero(), Vec3::Ones(), Vec3::Zero(), Vec3::Ones()});
      EXPECT_GT(made.duration(), 0) << x;
    } catch (const std::invalid_argument&) {
    }
  }
}

}  // namespace
}  // namespace vir
