#include "vir/geometry/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "vir/geometry/finite_pose.h"
#include "vir_test_rotations.h"

namespace vir {
namespace {

TEST(Pose, ComposesAndInverts) {
  const Pose T_A_B(expQuat(Vec3(0, 0, M_PI / 2)), Vec3(1, 2, 3));
  // A quarter turn about z takes (1, 0, 0) to (0, 1, 0); plus (1, 2, 3).
  EXPECT_LT((T_A_B * Vec3(1, 0, 0) - Vec3(1, 3, 3)).norm(), 1e-15);
  for (const Vec3& theta : vir_test::rotationVectors()) {
    const Pose T_B_C(expQuat(theta), Vec3(-4, 0.5, 2));
    const Vec3 x_C(0.3, -7, 11);
    EXPECT_LT(((T_A_B * T_B_C) * x_C - T_A_B * (T_B_C * x_C)).norm(), 1e-13);
    EXPECT_LT(((T_B_C.inverse() * T_B_C) * x_C - x_C).norm(), 1e-13);
    EXPECT_LT((T_B_C.R() * x_C + T_B_C.p - T_B_C * x_C).norm(), 1e-13);
  }
}

TEST(Pose, RotZTurnsXTowardsY) {
  EXPECT_LT((rotZ(M_PI / 2) * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((rotZ(0.7) - expSO3(Vec3(0, 0, 0.7))).norm(), 1e-15);
}

TEST(Pose, YawIsWhatIsLeftWithoutRollAndPitch) {
  for (double yaw : {-3.1, -1.0, 0.0, 1e-9, 0.5, 3.1}) {
    for (double pitch : {-89.9, -30.0, 0.0, 60.0, 89.9}) {
      for (double roll : {-170.0, 0.0, 45.0}) {
        const Mat3 R = rotZ(yaw) * expSO3(Vec3(0, pitch * M_PI / 180, 0)) *
                       expSO3(Vec3(roll * M_PI / 180, 0, 0));
        EXPECT_NEAR(yawOf(R), yaw, 1e-12) << "pitch " << pitch << " roll " << roll;
      }
    }
  }
}

TEST(Pose, GravityAlignedAttitudePointsUpWithoutYaw) {
  for (const Vec3& theta : vir_test::rotationVectors()) {
    const Vec3 up_B = expSO3(theta).transpose() * Vec3(0, 0, 9.81);
    const Quat q = gravityAlignedAttitude(up_B);
    EXPECT_LT((q * up_B - Vec3(0, 0, 9.81)).norm(), 1e-13) << theta.transpose();
    EXPECT_NEAR(q.norm(), 1, 1e-15);
    EXPECT_NEAR(yawOf(q.toRotationMatrix()), 0, 1e-12) << theta.transpose();
  }
}

TEST(Pose, GravityAlignedAttitudeOfAnUpsideDownOrPitchedBody) {
  for (const Vec3& up_B : {Vec3(0, 0, -9.81), Vec3(1e-9, 0, -9.81), Vec3(0, -1e-9, -1),
                           Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 1)}) {
    const Quat q = gravityAlignedAttitude(up_B);
    EXPECT_TRUE(q.coeffs().allFinite());
    EXPECT_LT((q * up_B.normalized() - Vec3::UnitZ()).norm(), 1e-12) << up_B.transpose();
  }
  EXPECT_LT(gravityAlignedAttitude(Vec3(0, 0, 3)).angularDistance(Quat::Identity()), 1e-15);
}

TEST(Pose, GravityAlignedAttitudeRefusesZeroAndNaN) {
  EXPECT_THROW(gravityAlignedAttitude(Vec3::Zero()), std::invalid_argument);
  EXPECT_THROW(gravityAlignedAttitude(Vec3(0, NAN, 1)), std::invalid_argument);
}

TEST(Pose, IsFiniteIfAllOfItsNumbersAre) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(isFinite(Pose()));
  EXPECT_TRUE(isFinite(Pose(Quat(0, 0, 0, 0), Vec3(1e308, 0, 0))));
  for (const double bad : {nan, inf, -inf}) {
    for (int i = 0; i < 3; ++i) {
      Pose pose;
      pose.p[i] = bad;
      EXPECT_FALSE(isFinite(pose)) << bad << " " << i;
    }
    for (int i = 0; i < 4; ++i) {
      Pose pose;
      pose.q.coeffs()[i] = bad;
      EXPECT_FALSE(isFinite(pose)) << bad << " " << i;
    }
  }
}

}  // namespace
}  // namespace vir
