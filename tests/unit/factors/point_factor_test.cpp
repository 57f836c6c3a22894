/// Factors of one block: a known point's sight and the host's own sight.
#include <gtest/gtest.h>

#include <cmath>

#include "vir/factors/reprojection_factor.h"
#include "vir_test_jacobian.h"
#include "vir_test_poses.h"

namespace vir::factors {
namespace {

using vir_test::poseBlock;

Pose extrinsic() { return {expQuat(Vec3(1.2, -1.1, 0.9)), Vec3(0.05, -0.02, 0.1)}; }

TEST(PointSightFactor, JacobiansEverywhere) {
  vir_test::JacobianTolerance tolerance;
  tolerance.relative = 1e-7;
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    for (double distance : {0.3, 4.0, 300.0}) {
      const Vec3 p_C = distance * Vec3(0.2, -0.3, 1).normalized();
      const Vec3 p_W = p.T * (extrinsic() * p_C);
      for (double error : {0.0, 0.1}) {
        Sight s;
        s.bearing = (p_C + error * distance * Vec3(1, 1, 0)).normalized();
        s.weight = 300 * tangentBasis(s.bearing).transpose();
        const PointSightFactor f(p_W, s, extrinsic());
        vir_test::expectJacobians(f, {poseBlock(p.T)}, p.name, tolerance);
        if (error == 0) {
          EXPECT_LT(vir_test::residualOf(f, {poseBlock(p.T)}).norm(), 1e-10);
        }
      }
    }
  }
}

TEST(PointSightFactor, ResidualByHand) {
  // Camera 0.5 m ahead of the body along z, body at the origin: the point (3, 0, 4.5) is at
  // (3, 0, 4) for the camera, bearing (0.6, 0, 0.8). Measured straight ahead: 100 * 0.6 = 60.
  Sight s;
  s.weight << 100, 0, 0, 0, 100, 0;
  const PointSightFactor f(Vec3(3, 0, 4.5), s, Pose(Quat::Identity(), Vec3(0, 0, 0.5)));
  const Eigen::VectorXd r = vir_test::residualOf(f, {poseBlock(Pose())});
  EXPECT_NEAR(r[0], 60, 1e-12);
  EXPECT_NEAR(r[1], 0, 1e-12);
}

TEST(PointSightFactor, BehindAndAtZeroDistanceStaysFinite) {
  Sight s;
  s.weight << 100, 0, 0, 0, 100, 0;
  for (const Vec3& p_W : {Vec3(0, 0, 0), Vec3(0, 0, 1e-13), Vec3(1e-10, 0, 0), Vec3(0, 0, -2)}) {
    const PointSightFactor f(p_W, s, Pose());
    Eigen::VectorXd r;
    EXPECT_TRUE(vir_test::analyticJacobians(f, {poseBlock(Pose())}, &r)[0].allFinite());
    EXPECT_TRUE(r.allFinite());
  }
}

TEST(HostSightFactor, JacobiansAndResidualByHand) {
  HostRay host;
  host.bearing = Vec3(0, 0, 1);
  host.basis.col(0) = Vec3(1, 0, 0);
  host.basis.col(1) = Vec3(0, 1, 0);
  Mat23 weight;
  weight << 100, 10, 0, 0, 200, 0;
  const HostSightFactor f(host, weight);
  const vir_test::Blocks x = {{0.01, 0.02, 0.7}};
  vir_test::expectJacobians(f, x, "host sight");
  // r = (100 * 0.01 + 10 * 0.02, 200 * 0.02) = (1.2, 4); the distance has no part in it.
  const Eigen::VectorXd r = vir_test::residualOf(f, x);
  EXPECT_NEAR(r[0], 1.2, 1e-14);
  EXPECT_NEAR(r[1], 4, 1e-14);
}

}  // namespace
}  // namespace vir::factors
