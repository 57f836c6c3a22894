#include "vir/factors/level_edge_factor.h"

#include <gtest/gtest.h>

#include "vir_test_jacobian.h"

namespace vir::factors {
namespace {

Eigen::Matrix4d someWeights() {
  Eigen::Matrix4d W = Eigen::Matrix4d::Identity();
  W.diagonal() << 20, 30, 40, 100;
  W(0, 3) = 5;
  W(2, 1) = -3;
  return W;
}

TEST(LevelEdgeFactor, IsZeroWhereTheEdgeHolds) {
  const double yaw = 0.7;
  const Vec3 p_a(1, 2, 3), motion_W(0.4, -0.2, 0.1);
  const Vec3 p_b = p_a + rotZ(yaw) * motion_W;
  const LevelEdgeFactor f(motion_W, 0.2, someWeights());
  const vir_test::Blocks x{{p_a.x(), p_a.y(), p_a.z(), yaw},
                           {p_b.x(), p_b.y(), p_b.z(), yaw + 0.2 + 2 * M_PI}};
  EXPECT_LT(vir_test::residualOf(f, x).norm(), 1e-11);
}

TEST(LevelEdgeFactor, Jacobians) {
  const LevelEdgeFactor f(Vec3(0.4, -0.2, 0.1), 3.0, someWeights());
  vir_test::expectJacobians(f, {{1, 2, 3, 0.7}, {1.5, 1.8, 3.3, -2.9}}, "edge");
  vir_test::expectJacobians(f, {{-5, 0, 0, -9}, {100, -80, 3, 2}}, "long edge");
}

}  // namespace
}  // namespace vir::factors
