#include "vir/geometry/so3.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vir_test_rotations.h"

namespace vir {
namespace {

/// Rodrigues' formula in long double: an independent reference.
Mat3 rodrigues(const Vec3& theta) {
  using Mat3l = Eigen::Matrix<long double, 3, 3>;
  const Eigen::Matrix<long double, 3, 1> t = theta.cast<long double>();
  const long double n = t.norm();
  if (n == 0) return Mat3::Identity();
  const Eigen::Matrix<long double, 3, 1> k = t / n;
  Mat3l K;
  K << 0, -k[2], k[1], k[2], 0, -k[0], -k[1], k[0], 0;
  const long double half = std::sin(n / 2);
  const Mat3l R = Mat3l::Identity() + std::sin(n) * K + 2 * half * half * K * K;
  return R.cast<double>();
}

TEST(So3, HatIsTheCrossProduct) {
  // (1, 2, 3) x (4, 5, 6) = (2*6 - 3*5, 3*4 - 1*6, 1*5 - 2*4) = (-3, 6, -3)
  EXPECT_TRUE((hat(Vec3(1, 2, 3)) * Vec3(4, 5, 6)).isApprox(Vec3(-3, 6, -3), 1e-15));
}

TEST(So3, ExpIsRodriguesFormula) {
  for (const Vec3& theta : vir_test::rotationVectors()) {
    EXPECT_LT((expSO3(theta) - rodrigues(theta)).norm(), 1e-15 * 10) << theta.transpose();
    EXPECT_NEAR(expQuat(theta).norm(), 1.0, 1e-15 * 2) << theta.transpose();
    EXPECT_LT((expQuat(theta).toRotationMatrix() - expSO3(theta)).norm(), 1e-15);
  }
}

TEST(So3, LogTakesExpBack) {
  for (const Vec3& theta : vir_test::rotationVectors()) {
    const double tolerance = 1e-15 + 4e-15 * theta.norm();
    if (theta.norm() < M_PI) {
      EXPECT_LT((logQuat(expQuat(theta)) - theta).norm(), tolerance) << theta.transpose();
      // A matrix near half a turn holds the axis in products of its components only.
      EXPECT_LT((logSO3(expSO3(theta)) - theta).norm(), 1e-14) << theta.transpose();
    }
    EXPECT_LT((expSO3(logQuat(expQuat(theta))) - expSO3(theta)).norm(), 1e-14);
  }
}

TEST(So3, LogOfBothQuaternionsOfARotationIsTheSame) {
  for (const Vec3& theta : vir_test::rotationVectors()) {
    const Quat q = expQuat(theta);
    const Quat minus(-q.w(), -q.x(), -q.y(), -q.z());
    EXPECT_EQ(logQuat(q), logQuat(minus)) << theta.transpose();
  }
}

TEST(So3, LogStaysInTheBallOfRadiusPi) {
  // A turn by 3/2 pi about x is the turn by -pi/2.
  EXPECT_LT((logQuat(expQuat(Vec3(1.5 * M_PI, 0, 0))) - Vec3(-M_PI / 2, 0, 0)).norm(), 1e-14);
  EXPECT_NEAR(logQuat(Quat(0, 0, 1, 0)).norm(), M_PI, 1e-15);
  EXPECT_NEAR(logQuat(Quat(-0.0, 0, 1, 0)).norm(), M_PI, 1e-15);
  EXPECT_EQ(logQuat(Quat::Identity()), Vec3::Zero());
}

TEST(So3, TinyRotationsKeepTheirDigits) {
  for (double angle : {1e-9, 1e-5}) {
    const Vec3 theta = angle * Vec3(0.6, 0, 0.8);
    EXPECT_LT((logQuat(expQuat(theta)) - theta).norm(), 1e-15 * angle);
  }
}

/// Column k of Jr: d/dt Log(Exp(theta)^-1 Exp(theta + t e_k)) at 0, by central differences.
Mat3 numericRightJacobian(const Vec3& theta) {
  const double h = 1e-5;
  const Quat inverse = expQuat(theta).conjugate();
  Mat3 J;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = h * Vec3::Unit(k);
    J.col(k) =
        (logQuat(inverse * expQuat(theta + d)) - logQuat(inverse * expQuat(theta - d))) / (2 * h);
  }
  return J;
}

TEST(So3, RightJacobianIsTheDerivativeOfExp) {
  for (const Vec3& theta : vir_test::rotationVectors()) {
    EXPECT_LT((rightJacobianSO3(theta) - numericRightJacobian(theta)).norm(), 1e-9)
        << theta.transpose();
  }
}

TEST(So3, InverseRightJacobianIsTheDerivativeOfLog) {
  const double h = 1e-5;
  for (const Vec3& theta : vir_test::rotationVectors()) {
    if (theta.norm() > M_PI - 1e-4) continue;  // the steps would cross to the other side of pi
    const Quat q = expQuat(theta);
    Mat3 J;
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = h * Vec3::Unit(k);
      J.col(k) = (logQuat(q * expQuat(d)) - logQuat(q * expQuat(-d))) / (2 * h);
    }
    EXPECT_LT((rightJacobianInverseSO3(theta) - J).norm(), 2e-9) << theta.transpose();
  }
}

TEST(So3, JacobianTimesItsInverseIsIdentityUpToPi) {
  for (Vec3 theta : vir_test::rotationVectors()) {
    for (double scale : {1.0, -1.0}) {
      const Mat3 I = rightJacobianSO3(scale * theta) * rightJacobianInverseSO3(scale * theta);
      EXPECT_LT((I - Mat3::Identity()).norm(), 1e-12) << theta.transpose();
    }
  }
  const Vec3 half_turn(0, M_PI, 0);
  EXPECT_LT(
      (rightJacobianSO3(half_turn) * rightJacobianInverseSO3(half_turn) - Mat3::Identity()).norm(),
      1e-14);
}

}  // namespace
}  // namespace vir
