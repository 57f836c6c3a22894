#include "vir/factors/reprojection_factor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vir_test_jacobian.h"
#include "vir_test_poses.h"

namespace vir::factors {
namespace {

using vir_test::Blocks;
using vir_test::poseBlock;

Pose extrinsic() { return {expQuat(Vec3(1.2, -1.1, 0.9)), Vec3(0.05, -0.02, 0.1)}; }

CameraVector reference() {
  CameraVector c = CameraVector::Zero();
  c[kTimeOffset] = 0.01;
  return c;
}

std::vector<double> cameraBlock(const CameraVector& c) { return {c.data(), c.data() + c.size()}; }

/// Every parameter has a column: a row too short or too long does not compile.
CameraJacobian jacobian(const double (&x)[kCameraParameters], const double (&y)[kCameraParameters],
                        const double (&z)[kCameraParameters]) {
  CameraJacobian J;
  J << CameraVector::Map(x).transpose(), CameraVector::Map(y).transpose(),
      CameraVector::Map(z).transpose();
  return J;
}

HostRay hostRay(const Vec3& bearing) {
  HostRay h;
  h.bearing = bearing.normalized();
  h.basis = tangentBasis(h.bearing);
  h.by_camera = jacobian({0.3, -0.2, 0.5, 0.1, 0.002, 0.001, 0.08, -0.03},
                         {-0.2, 0.1, 0.3, -0.4, 0.001, 0.002, -0.05, 0.02},
                         {0.1, 0.05, -0.1, 0.2, 0.0, -0.001, 0.01, 0.04});
  h.at = reference();
  return h;
}

Sight sightOf(const Vec3& direction) {
  Sight s;
  s.bearing = direction.normalized();
  s.weight = 200 * tangentBasis(s.bearing).transpose();
  s.weight(0, 1) += 30;  // a distorted camera's Jacobian is not orthogonal
  s.by_camera = jacobian({-0.1, 0.05, -0.3, 0.2, 0.002, 0.0, 0.09, 0.02},
                         {0.4, -0.2, 0.6, 0.3, -0.001, 0.002, -0.06, 0.05},
                         {0.2, 0.1, 0.1, -0.1, 0.001, 0.001, 0.03, -0.01});
  s.at = reference();
  return s;
}

/// Frame j seen from i: turned a little and moved, so that the point is in front of both.
Pose nextTo(const Pose& T_W_Bi) {
  return T_W_Bi * Pose(expQuat(Vec3(0.1, -0.15, 0.2)), Vec3(0.3, 0.2, -0.1));
}

struct Case {
  HostRay host;
  Sight sight;
  Blocks x;  // pose i, pose j, extrinsic, landmark, camera
};

Case caseAt(const Pose& T_W_Bi, double rho, double error) {
  Case c;
  c.host = hostRay(Vec3(0.2, -0.1, 1));
  const Vec3 landmark(0.01, -0.02, rho);
  const Pose T_W_Bj = nextTo(T_W_Bi);
  // rho times the point in camera j; finite at rho = 0.
  const Vec3 d = c.host.bearing + c.host.basis * landmark.head<2>();
  const Vec3 x_W =
      T_W_Bi.q * (extrinsic().q * d + rho * extrinsic().p) + rho * (T_W_Bi.p - T_W_Bj.p);
  const Vec3 s = extrinsic().q.conjugate() * (T_W_Bj.q.conjugate() * x_W - rho * extrinsic().p);
  c.sight = sightOf(s + error * s.norm() * Vec3(1, -1, 0.5));
  c.x = {poseBlock(T_W_Bi),
         poseBlock(T_W_Bj),
         poseBlock(extrinsic()),
         {landmark[0], landmark[1], landmark[2]},
         {0.015, 0.002, 0.01, -0.003, 2.0, -1.5, 0.02, -0.01}};
  return c;
}

Blocks withoutCalibration(const Case& c) { return {c.x[0], c.x[1], c.x[3]}; }

vir_test::JacobianTolerance tolerance() {
  vir_test::JacobianTolerance t;
  t.relative = 1e-7;
  t.absolute = 1e-6;
  return t;
}

TEST(ReprojectionFactor, JacobiansEverywhere) {
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    for (double rho : {1.0, 0.2, 1e-3, 0.0, -0.05}) {
      for (double error : {0.0, 0.05}) {
        const Case c = caseAt(p.T, rho, error);
        const std::string what = p.name + ", rho " + std::to_string(rho);
        const ReprojectionFactor f(c.host, c.sight, extrinsic(), reference());
        vir_test::expectJacobians(f, withoutCalibration(c), what, tolerance());
        const ReprojectionCalibrationFactor g(c.host, c.sight);
        vir_test::expectJacobians(g, c.x, what + ", calibration", tolerance());
      }
    }
  }
}

TEST(ReprojectionFactor, ResidualByHand) {
  // Camera = body. Host at the origin looks at (0, 0, 2): rho = 0.5. Frame j stands at (1, 0, 0),
  // not turned: sees the point at (-1, 0, 2), bearing (-1, 0, 2)/sqrt(5) = (-0.447214, 0,
  // 0.894427). Measured straight ahead with weight 100 in x and y: residual (-44.7214, 0).
  const HostRay host = hostRay(Vec3(0, 0, 1));
  Sight s;
  s.weight << 100, 0, 0, 0, 100, 0;
  const ReprojectionFactor f(host, s, Pose(), reference());
  const Blocks x = {
      poseBlock(Pose()), poseBlock(Pose(Quat::Identity(), Vec3(1, 0, 0))), {0, 0, 0.5}};
  const Eigen::VectorXd r = vir_test::residualOf(f, x);
  EXPECT_NEAR(r[0], -100 / std::sqrt(5.0), 1e-12);
  EXPECT_NEAR(r[1], 0, 1e-12);
  // With calibration at the reference offset it is the same.
  const ReprojectionCalibrationFactor g(host, s);
  EXPECT_LT(
      (vir_test::residualOf(g, {x[0], x[1], poseBlock(Pose()), x[2], cameraBlock(host.at)}) - r)
          .norm(),
      1e-12);
}

TEST(ReprojectionFactor, TheCamerasParametersMoveTheMeasuredBearings) {
  // Point at infinity, no motion: predicted = host bearing, measured = bearing + by_camera (c -
  // at). Image moving at 0.5/s along x, offset 0.01 s more than stamped with: measured 0.005 less,
  // r = 100 * 0.005 = 0.5 in x. Focal length 1 % more, seen 0.2 off the centre: 0.002 less, r =
  // 0.2.
  HostRay host = hostRay(Vec3(0, 0, 1));
  host.by_camera.setZero();
  Sight s;
  s.weight << 100, 0, 0, 0, 100, 0;
  s.by_camera.col(kTimeOffset) = Vec3(-0.5, 0, 0);
  s.by_camera.col(kFocal) = Vec3(-0.2, 0, 0);
  s.at = reference();
  const ReprojectionCalibrationFactor f(host, s);
  const std::vector<double> I = poseBlock(Pose());
  CameraVector c = reference();
  c[kTimeOffset] += 0.01;
  EXPECT_NEAR(vir_test::residualOf(f, {I, I, I, {0, 0, 0}, cameraBlock(c)})[0], 0.5, 1e-12);
  c = reference();
  c[kFocal] = 0.01;
  EXPECT_NEAR(vir_test::residualOf(f, {I, I, I, {0, 0, 0}, cameraBlock(c)})[0], 0.2, 1e-12);
  // The same without a parameter for it.
  const ReprojectionFactor g(host, s, Pose(), c);
  EXPECT_NEAR(vir_test::residualOf(g, {I, I, {0, 0, 0}})[0], 0.2, 1e-12);
}

TEST(ReprojectionFactor, PointsAtInfinityDoNotFeelTranslation) {
  const Case c = caseAt(Pose(), 0.0, 0.01);
  const ReprojectionFactor f(c.host, c.sight, extrinsic(), reference());
  Blocks x = withoutCalibration(c);
  const Eigen::VectorXd before = vir_test::residualOf(f, x);
  x[1][0] += 1e6;
  EXPECT_LT((vir_test::residualOf(f, x) - before).norm(), 1e-9);
}

TEST(ReprojectionFactor, BehindTheCameraAndAtZeroDistanceStaysFinite) {
  const HostRay host = hostRay(Vec3(0, 0, 1));
  const Sight s = sightOf(Vec3(0, 0, 1));
  const std::vector<double> I = poseBlock(Pose());
  // The point (0, 0, 1) seen from exactly there, from just there, and from beyond it.
  for (double z : {1.0, 1.0 + 1e-12, 1.0 + 1e-7, 3.0}) {
    const std::vector<double> j = poseBlock(Pose(Quat::Identity(), Vec3(0, 0, z)));
    const ReprojectionFactor f(host, s, Pose(), reference());
    const ReprojectionCalibrationFactor g(host, s);
    for (const auto& [cost, x] : std::vector<std::pair<const ceres::CostFunction*, Blocks>>{
             {&f, {I, j, {0, 0, 1}}}, {&g, {I, j, I, {0, 0, 1}, cameraBlock(reference())}}}) {
      Eigen::VectorXd r;
      for (const auto& J : vir_test::analyticJacobians(*cost, x, &r)) {
        EXPECT_TRUE(J.allFinite()) << z;
      }
      EXPECT_TRUE(r.allFinite()) << z;
    }
  }
}

TEST(ReprojectionFactor, APointBehindIsFarFromAnyMeasurement) {
  // Half a turn off: |predicted - measured| = 2, and weight keeps what is across the bearing only,
  // so a point exactly behind must not look perfect to an outlier test. Slightly off axis it is
  // seen as just as slightly off: what rejects it is the sign of its depth.
  const Case c = caseAt(Pose(), 0.5, 0.0);
  const ReprojectionFactor f(c.host, c.sight, extrinsic(), reference());
  EXPECT_LT(vir_test::residualOf(f, withoutCalibration(c)).norm(), 1e-9);
  Blocks x = withoutCalibration(c);
  x[2][2] = -0.5;
  EXPECT_GT(vir_test::residualOf(f, x).norm(), 10);
}

TEST(ReprojectionFactor, JacobiansStandAtTheFirstEstimateResidualsDoNot) {
  const Case now = caseAt(vir_test::poses().back().T, 0.3, 0.02);
  const Case first = caseAt(vir_test::poses()[1].T, 0.3, 0.02);
  for (int mask = 1; mask < 4; ++mask) {
    Case at = now;
    for (int k = 0; k < 2; ++k) {
      if (mask >> k & 1) at.x[k] = first.x[k];
    }
    const double* i = mask & 1 ? first.x[0].data() : nullptr;
    const double* j = mask & 2 ? first.x[1].data() : nullptr;
    Eigen::VectorXd r, unused;
    {
      ReprojectionFactor f(now.host, now.sight, extrinsic(), reference());
      const ReprojectionFactor plain(now.host, now.sight, extrinsic(), reference());
      f.linearizeAt(i, j);
      const auto J = vir_test::analyticJacobians(f, withoutCalibration(now), &r);
      const auto expected = vir_test::analyticJacobians(plain, withoutCalibration(at), &unused);
      EXPECT_EQ(r, vir_test::residualOf(plain, withoutCalibration(now)));
      for (int k = 0; k < 3; ++k) EXPECT_TRUE(J[k] == expected[k]) << mask << " " << k;
      vir_test::expectNullBlocksWork(f, withoutCalibration(now), "first estimates");
    }
    ReprojectionCalibrationFactor f(now.host, now.sight);
    const ReprojectionCalibrationFactor plain(now.host, now.sight);
    f.linearizeAt(i, j);
    const auto J = vir_test::analyticJacobians(f, now.x, &r);
    const auto expected = vir_test::analyticJacobians(plain, at.x, &unused);
    EXPECT_EQ(r, vir_test::residualOf(plain, now.x));
    for (int k = 0; k < 5; ++k) EXPECT_TRUE(J[k] == expected[k]) << mask << " " << k;
    vir_test::expectNullBlocksWork(f, now.x, "first estimates, calibration");
  }
}

TEST(TangentBasis, IsOrthonormalForEveryDirection) {
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 n = p.T.q * Vec3::Unit(axis);
      Mat3 B;
      B << tangentBasis(n), n;
      EXPECT_LT((B.transpose() * B - Mat3::Identity()).norm(), 1e-14) << n.transpose();
    }
  }
}

}  // namespace
}  // namespace vir::factors
