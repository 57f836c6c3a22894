#include "vir/factors/motion_factors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vir_test_jacobian.h"
#include "vir_test_poses.h"

namespace vir::factors {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;
using vir_test::poseBlock;

TEST(ZeroVelocityFactor, JacobiansAndResidualByHand) {
  const ZeroVelocityFactor f(0.01);
  const vir_test::Blocks x = {{0.02, -0.01, 0.03, 1, 2, 3, 4, 5, 6}};
  vir_test::expectJacobians(f, x, "zero velocity");
  // v / 0.01 = (2, -1, 3); biases have no part in it.
  EXPECT_LT((vir_test::residualOf(f, x) - Vec3(2, -1, 3)).norm(), 1e-12);
}

TEST(RelativePoseFactor, JacobiansEverywhere) {
  Mat6 W = Mat6::Identity();
  W.diagonal() << 10, 20, 30, 100, 200, 300;
  W(0, 4) = 7;  // weights may couple
  const Pose z(expQuat(Vec3(0.3, -0.2, 0.5)), Vec3(1, 2, -0.5));
  vir_test::JacobianTolerance tolerance;
  tolerance.relative = 1e-7;
  const RelativePoseFactor f(z, W);
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    for (double error : {0.0, 0.1, 1.5}) {
      const Pose T_j = p.T * z * Pose(expQuat(error * Vec3(1, -1, 0.5)), error * Vec3(1, 2, 3));
      const vir_test::Blocks x = {poseBlock(p.T), poseBlock(T_j)};
      vir_test::expectJacobians(f, x, p.name + ", error " + std::to_string(error), tolerance);
      if (error == 0) {
        EXPECT_LT(vir_test::residualOf(f, x).norm(), 1e-11) << p.name;
      }
    }
  }
}

TEST(RelativePoseFactor, ResidualByHand) {
  // i at (1, 0, 0) turned by 90 degrees about z; j at (1, 2, 0) turned by 90 degrees + 0.1 rad.
  // R_i^T (p_j - p_i) = Rz(-90) (0, 2, 0) = (2, 0, 0); against z.p = (1.5, 0, 0): 0.5.
  const RelativePoseFactor f(Pose(Quat::Identity(), Vec3(1.5, 0, 0)), 2 * Mat6::Identity());
  const Eigen::VectorXd r = vir_test::residualOf(
      f, {poseBlock(Pose(expQuat(Vec3(0, 0, M_PI / 2)), Vec3(1, 0, 0))),
          poseBlock(Pose(expQuat(Vec3(0, 0, M_PI / 2 + 0.1)), Vec3(1, 2, 0)))});
  Eigen::Matrix<double, 6, 1> expected;
  expected << 1.0, 0, 0, 0, 0, 0.2;
  EXPECT_LT((r - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace vir::factors
