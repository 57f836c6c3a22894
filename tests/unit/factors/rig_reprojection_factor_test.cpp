#include <gtest/gtest.h>

#include <cmath>

#include "vir/factors/reprojection_factor.h"
#include "vir_test_jacobian.h"
#include "vir_test_poses.h"

namespace vir::factors {
namespace {

using vir_test::Blocks;
using vir_test::poseBlock;

Pose left() { return {expQuat(Vec3(1.2, -1.1, 0.9)), Vec3(0.05, -0.02, 0.1)}; }
Pose right() { return {expQuat(Vec3(1.25, -1.05, 0.85)), Vec3(0.04, 0.1, 0.12)}; }

HostRay hostRay() {
  HostRay h;
  h.bearing = Vec3(0.2, -0.1, 1).normalized();
  h.basis = tangentBasis(h.bearing);
  for (int i = 0; i < kCameraParameters; ++i) h.by_camera.col(i) = Vec3(0.3, -0.2, 0.1) / (1 + i);
  h.at[kTimeOffset] = 0.01;
  return h;
}

Sight sight() {
  Sight s;
  s.bearing = Vec3(0.15, -0.12, 1).normalized();
  s.weight = 200 * tangentBasis(s.bearing).transpose();
  for (int i = 0; i < kCameraParameters; ++i) s.by_camera.col(i) = Vec3(-0.1, 0.4, 0.2) / (2 + i);
  s.at[kTimeOffset] = 0.012;
  return s;
}

std::vector<double> camera(double by) {
  return {0.015 + by, 0.002, 0.01, -0.003, 0.2, -0.15, 0.02, -0.01};
}

vir_test::JacobianTolerance tolerance() {
  vir_test::JacobianTolerance t;
  t.relative = 1e-7;
  t.absolute = 1e-6;
  return t;
}

TEST(RigReprojectionFactor, ResidualOfAPairByHand) {
  // Both cameras look along z of the body, the right one 0.1 m beside the left. A point 2 m ahead
  // of the left one is seen by the right at (-0.1, 0, 2): bearing (-0.0499376, 0, 0.998752).
  // Measured straight ahead with weight 100: residual (-4.99376, 0), wherever the body is.
  HostRay host;
  host.basis = tangentBasis(host.bearing);
  Sight s;
  s.weight << 100, 0, 0, 0, 100, 0;
  RigReprojectionFactor::Known known;
  known.T_B_Cj.p = Vec3(0.1, 0, 0);
  known.camera_i = known.camera_j = CameraVector::Zero();
  const RigReprojectionFactor f(host, s, true, &known);
  const Eigen::VectorXd r = vir_test::residualOf(f, {{0, 0, 0.5}});
  EXPECT_NEAR(r[0], -100 * 0.1 / std::sqrt(4.01), 1e-12);
  EXPECT_NEAR(r[1], 0, 1e-12);
  // From another frame, 0.1 m farther to the left, the right camera is where the left was.
  const RigReprojectionFactor g(host, s, false, &known);
  const Blocks x = {
      {0, 0, 0.5}, poseBlock(Pose()), poseBlock(Pose(Quat::Identity(), Vec3(-0.1, 0, 0)))};
  EXPECT_LT(vir_test::residualOf(g, x).norm(), 1e-12);
}

TEST(RigReprojectionFactor, JacobiansOfEveryKind) {
  const HostRay host = hostRay();
  const Sight s = sight();
  const RigReprojectionFactor::Known known{left(), right(), CameraVector(camera(0).data()),
                                           CameraVector(camera(0.001).data())};
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    const Pose T_W_Bj = p.T * Pose(expQuat(Vec3(0.1, -0.15, 0.2)), Vec3(0.3, 0.2, -0.1));
    for (const double rho : {1.0, 0.2, 0.0, -0.05}) {
      const std::vector<double> landmark{0.01, -0.02, rho};
      const std::string what = p.name + ", rho " + std::to_string(rho);
      const Blocks poses{landmark, poseBlock(p.T), poseBlock(T_W_Bj)};
      vir_test::expectJacobians(RigReprojectionFactor(host, s, false, &known), poses,
                                what + ", known", tolerance());
      Blocks all = poses, pair{landmark};
      for (Blocks* x : {&all, &pair}) {
        x->push_back(poseBlock(left()));
        x->push_back(camera(0));
        x->push_back(poseBlock(right()));
        x->push_back(camera(0.001));
      }
      vir_test::expectJacobians(RigReprojectionFactor(host, s, false), all, what, tolerance());
      vir_test::expectJacobians(RigReprojectionFactor(host, s, true), pair, what + ", one frame",
                                tolerance());
      vir_test::expectJacobians(RigReprojectionFactor(host, s, true, &known), {landmark},
                                what + ", one frame, known", tolerance());
    }
  }
}

TEST(RigReprojectionFactor, OneCameraTwiceIsOneCamera) {
  const HostRay host = hostRay();
  const Sight s = sight();
  const Pose T_W_Bi(expQuat(Vec3(0.3, 0.1, -0.2)), Vec3(1, 2, 3));
  const Pose T_W_Bj = T_W_Bi * Pose(expQuat(Vec3(0.1, -0.15, 0.2)), Vec3(0.3, 0.2, -0.1));
  const CameraVector c(camera(0).data());
  const RigReprojectionFactor::Known known{left(), left(), c, c};
  const std::vector<double> landmark{0.01, -0.02, 0.3};
  const Eigen::VectorXd rig =
      vir_test::residualOf(RigReprojectionFactor(host, s, false, &known),
                           {landmark, poseBlock(T_W_Bi), poseBlock(T_W_Bj)});
  const Eigen::VectorXd one = vir_test::residualOf(
      ReprojectionFactor(host, s, left(), c), {poseBlock(T_W_Bi), poseBlock(T_W_Bj), landmark});
  EXPECT_EQ((rig - one).norm(), 0);
}

}  // namespace
}  // namespace vir::factors
