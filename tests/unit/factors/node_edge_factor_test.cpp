/// The factors that tie nodes of the long window to one another.
#include "vir/factors/node_edge_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "nodes.h"
#include "vir/factors/drift_edge_factor.h"
#include "vir/factors/position_link_factor.h"
#include "vir_test_jacobian.h"

namespace vir::factors {
namespace {

using test::difficultNodes;
using test::NamedNode;
using vir_test::Blocks;
using vir_test::residualOf;

TEST(NodeEdgeFactor, ResidualByHand) {
  // From (1, 1, 0) to (1, 3, 0) with O turned by 90 degrees: (2, 0, 0) in O; the odometry, twice
  // too long, says (3, 0, 0), which is 1.5: 0.5 m off, weight 10. Yaw +0.1, weight 100. Scale
  // -log 2 at sigma 0.1.
  Eigen::Matrix4d W = Eigen::Matrix4d::Zero();
  W.diagonal() << 10, 10, 10, 100;
  const NodeEdgeFactor f(Vec3(3, 0, 0), W, 0.1);
  const Eigen::VectorXd r =
      residualOf(f, {{1, 1, 0, M_PI / 2, std::log(2.0)}, {1, 3, 0, M_PI / 2 + 0.1, 0}});
  Eigen::Matrix<double, 5, 1> expected;
  expected << 5, 0, 0, 10, -10 * std::log(2.0);
  EXPECT_LT((r - expected).norm(), 1e-12);
}

TEST(NodeEdgeFactor, JacobiansEverywhere) {
  Eigen::Matrix4d W = Eigen::Matrix4d::Zero();
  W.diagonal() << 20, 30, 40, 200;
  W(0, 3) = 7;  // weights may couple
  W(1, 2) = -3;
  vir_test::JacobianTolerance tolerance;
  tolerance.relative = 1e-7;
  const NodeEdgeFactor f(Vec3(0.5, -0.3, 0.2), W, 0.01);
  const std::vector<NamedNode> nodes = difficultNodes();
  for (const NamedNode& a : nodes) {
    for (const NamedNode& b : nodes) {
      vir_test::expectJacobians(f, {a.x, b.x}, a.name + " to " + b.name, tolerance);
    }
  }
}

TEST(NodeEdgeFactor, IsTheSameSeenFromAnywhere) {
  Eigen::Matrix4d W = Eigen::Matrix4d::Identity();
  W(0, 0) = 5;
  const NodeEdgeFactor f(Vec3(0.5, -0.3, 0.2), W, 0.01);
  const std::vector<double> a = {1, 2, 3, 0.5, 0.1}, b = {1.5, 2.2, 3.1, 0.6, 0.12};
  const double turn = 2.5;
  const auto moved = [&](const std::vector<double>& x) {
    const Vec3 p = rotZ(turn) * Vec3(x.data()) + Vec3(10, -20, 30);
    return std::vector<double>{p.x(), p.y(), p.z(), x[3] + turn, x[4]};
  };
  EXPECT_LT((residualOf(f, {a, b}) - residualOf(f, {moved(a), moved(b)})).norm(), 1e-11);
}

/// The heading errs by 0.02 rad/m and -0.1 rad/rad: 0.04 - 0.05 over 2 m and half a radian.
TEST(DriftEdgeFactor, ResidualByHandAndJacobians) {
  Eigen::Matrix4d W = Eigen::Matrix4d::Zero();
  W.diagonal() << 20, 30, 40, 200;
  const Vec3 motion(0.5, -0.3, 0.2);
  const std::vector<double> drift = {0.02, -0.1};
  vir_test::JacobianTolerance tolerance;
  tolerance.relative = 1e-7;
  for (const NamedNode& a : difficultNodes()) {
    for (const NamedNode& b : difficultNodes()) {
      const Eigen::VectorXd plain = residualOf(NodeEdgeFactor(motion, W, 0.01), {a.x, b.x});
      const DriftEdgeFactor f(motion, W, 0.01, 2, 0.5);
      Eigen::VectorXd off = residualOf(f, {a.x, b.x, drift}) - plain;
      off[3] -= 200 * 0.01;
      EXPECT_LT(off.norm(), 1e-9 * (1 + plain.norm())) << a.name << " to " << b.name;
      Eigen::Matrix4d coupled = W;
      coupled(0, 3) = 7;
      vir_test::expectJacobians(DriftEdgeFactor(motion, coupled, 0.01, 2, 0.5), {a.x, b.x, drift},
                                a.name + " to " + b.name, tolerance);
    }
  }
}

TEST(PositionLinkFactor, ResidualByHandAndJacobians) {
  const PositionLinkFactor f(Vec3(1, 2, 3), 100);
  const Blocks x = {{1, 1, 1, 3.1, 0.2}, {2.01, 3.02, 3.97, -3.1, 0.4}};
  // 100 ((1.01, 2.02, 2.97) - (1, 2, 3)).
  EXPECT_LT((residualOf(f, x) - Vec3(1, 2, -3)).norm(), 1e-11);
  vir_test::expectJacobians(f, x, "link");
}

}  // namespace
}  // namespace vir::factors
