#include "vir/geometry/interpolation.h"

#include <gtest/gtest.h>

namespace vir {
namespace {

constexpr double kPi = 3.14159265358979323846;

TEST(Interpolate, LinearAndTheShorterWayRound) {
  const Pose a(expQuat(Vec3(0, 0, 0.9 * kPi)), Vec3(0, 0, 0));
  Pose b(expQuat(Vec3(0, 0, -0.9 * kPi)), Vec3(1, 2, 3));
  b.q.coeffs() = -b.q.coeffs();  // the same attitude
  const Pose m = interpolate(a, b, 0.5);
  EXPECT_LT((m.p - Vec3(0.5, 1, 1.5)).norm(), 1e-15);
  EXPECT_NEAR(std::abs(logQuat(m.q).z()), kPi, 1e-12);
}

}  // namespace
}  // namespace vir
