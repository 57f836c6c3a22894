#include "vir/factors/pose_manifold.h"

#include <gtest/gtest.h>

#include "vir_test_poses.h"
#include "vir_test_rotations.h"

namespace vir::factors {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

TEST(PoseManifold, ArraysHoldPositionThenQuaternionWithWLast) {
  const Pose T(Quat(0.5, -0.5, 0.5, 0.5), Vec3(1, 2, 3));  // w, x, y, z
  double x[7];
  poseTo(T, x);
  const double expected[7] = {1, 2, 3, -0.5, 0.5, 0.5, 0.5};
  for (int i = 0; i < 7; ++i) EXPECT_EQ(x[i], expected[i]) << i;
  EXPECT_EQ(poseFrom(x).p, T.p);
  EXPECT_EQ(poseFrom(x).q.coeffs(), T.q.coeffs());
}

TEST(PoseManifold, PlusMovesPositionInWorldAndTurnsOnTheRight) {
  const Pose T(expQuat(Vec3(0, 0, M_PI / 2)), Vec3(1, 2, 3));
  double x[7], y[7];
  poseTo(T, x);
  const double delta[6] = {0.1, 0, 0, M_PI / 2, 0, 0};
  ASSERT_TRUE(PoseManifold().Plus(x, delta, y));
  const Pose P = poseFrom(y);
  EXPECT_LT((P.p - Vec3(1.1, 2, 3)).norm(), 1e-15) << "the position does not turn with the body";
  // First a quarter turn about the body's x: body y goes to z, then Rz leaves z where it is.
  EXPECT_LT((P.q * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-15);
}

TEST(PoseManifold, MinusTakesPlusBack) {
  const PoseManifold m;
  for (const vir_test::NamedPose& named : vir_test::poses()) {
    double x[7];
    poseTo(named.T, x);
    for (const Vec3& theta : vir_test::rotationVectors()) {
      if (theta.norm() > M_PI) continue;
      Vec6 delta, back;
      delta << Vec3(0.3, -4, 1e-7), theta;
      double y[7];
      ASSERT_TRUE(m.Plus(x, delta.data(), y));
      ASSERT_TRUE(m.Minus(y, x, back.data()));
      EXPECT_LT((back - delta).norm(), 1e-13) << named.name << ", " << theta.transpose();
      EXPECT_NEAR(poseFrom(y).q.norm(), 1, 1e-15);
      double z[7];
      ASSERT_TRUE(m.Plus(x, back.data(), z));
      EXPECT_LT(poseFrom(z).q.angularDistance(poseFrom(y).q), 1e-13);
    }
  }
}

TEST(PoseManifold, ZeroStepChangesNothing) {
  for (const vir_test::NamedPose& named : vir_test::poses()) {
    double x[7], y[7];
    poseTo(named.T, x);
    Vec6 delta = Vec6::Zero();
    PoseManifold().Plus(x, delta.data(), y);
    PoseManifold().Minus(y, x, delta.data());
    EXPECT_LT(delta.norm(), 1e-15) << named.name;
  }
}

TEST(PoseManifold, JacobiansAreThoseOfTheLiftedConvention) {
  const PoseManifold m;
  EXPECT_EQ(m.AmbientSize(), 7);
  EXPECT_EQ(m.TangentSize(), 6);
  double x[7];
  poseTo(Pose(), x);
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
  ASSERT_TRUE(m.PlusJacobian(x, plus.data()));
  ASSERT_TRUE(m.MinusJacobian(x, minus.data()));
  EXPECT_EQ((minus * plus).eval(), (Eigen::Matrix<double, 6, 6>::Identity().eval()));
  EXPECT_EQ(plus.row(6).norm(), 0);
}

}  // namespace
}  // namespace vir::factors
