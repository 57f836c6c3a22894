#include "vir/factors/reprojection_factor.h"

#include <cmath>

#include "vir/factors/pose_manifold.h"

namespace vir::factors {
namespace {
using RowMajor2x7 = Eigen::Matrix<double, 2, 7, Eigen::RowMajor>;
using RowMajor2x6 = Eigen::Matrix<double, 2, kCameraParameters, Eigen::RowMajor>;
using RowMajor2x3 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

void lift(const Eigen::Matrix<double, 2, 6>& J, double* out) {
  if (!out) return;
  Eigen::Map<RowMajor2x7> M(out);
  M.leftCols<6>() = J;
  M.col(6).setZero();
}
}  // namespace

Mat32 tangentBasis(const Vec3& unit) {
  // The axis the vector is least along gives the best-conditioned cross product.
  int axis = 0;
  unit.cwiseAbs().minCoeff(&axis);
  const Vec3 e = Vec3::Unit(axis);
  const Vec3 a = unit.cross(e).normalized();
  Mat32 B;
  B.col(0) = a;
  B.col(1) = unit.cross(a);
  return B;
}

SightGeometry::SightGeometry(const Pose& T_W_Bi, const Pose& T_W_Bj, const Pose& T_B_C)
    : p_B_C(T_B_C.p) {
  const Mat3 R_B_C = T_B_C.R();
  const Mat3 R_W_Bi = T_W_Bi.R();
  R_C_B = R_B_C.transpose();
  R_Cj_W = R_C_B * T_W_Bj.R().transpose();
  R_Cj_Bi = R_Cj_W * R_W_Bi;
  R_Cj_Ci = R_Cj_Bi * R_B_C;
  t_Cj = R_Cj_W * (R_W_Bi * p_B_C + T_W_Bi.p - T_W_Bj.p) - R_C_B * p_B_C;
}

Vec2 reprojectionResidual(const HostRay& host, const Sight& sight, const Pose& T_W_Bi,
                          const Pose& T_W_Bj, const Pose& T_B_C, const Vec3& landmark,
                          const CameraVector& camera, ReprojectionJacobians* J) {
  return reprojectionResidual(host, sight, SightGeometry(T_W_Bi, T_W_Bj, T_B_C), landmark, camera,
                              J);
}

Vec2 reprojectionResidual(const HostRay& host, const Sight& sight, const SightGeometry& g,
                          const Vec3& landmark, const CameraVector& camera,
                          ReprojectionJacobians* J) {
  const double rho = landmark[2];
  const Vec3 d = host.bearingAt(camera) + host.basis * landmark.head<2>();
  const Vec3 s = g.R_Cj_Ci * d + rho * g.t_Cj;
  const double n = std::max(s.norm(), 1e-9);
  const Vec3 su = s / n;
  const Vec2 r = sight.weight * (su - sight.bearingAt(camera));
  if (!J) return r;

  const Mat23 D = (sight.weight - (sight.weight * su) * su.transpose()) / n;
  const Mat23 D_Bj = D * g.R_C_B;
  const Mat23 D_Bi = D * g.R_Cj_Bi;
  const Mat23 D_Ci = D * g.R_Cj_Ci;
  const Vec3 x_Bi = g.R_C_B.transpose() * d + rho * g.p_B_C;
  const Vec3 x_Bj = g.R_C_B.transpose() * s + rho * g.p_B_C;
  J->pose_i.leftCols<3>() = rho * (D * g.R_Cj_W);
  J->pose_i.rightCols<3>() = -D_Bi * hat(x_Bi);
  J->pose_j.leftCols<3>() = -J->pose_i.leftCols<3>();
  J->pose_j.rightCols<3>() = D_Bj * hat(x_Bj);
  J->extrinsic.leftCols<3>() = rho * (D_Bi - D_Bj);
  J->extrinsic.rightCols<3>() = D * hat(s) - D_Ci * hat(d);
  J->landmark.leftCols<2>() = D_Ci * host.basis;
  J->landmark.col(2) = D * g.t_Cj;
  J->camera = D_Ci * host.by_camera - sight.weight * sight.by_camera;
  return r;
}

bool ReprojectionFactor::Evaluate(double const* const* x, double* residuals,
                                  double** jacobians) const {
  const Vec3 landmark(x[2][0], x[2][1], x[2][2]);
  const bool elsewhere = lin_i_ || lin_j_;
  ReprojectionJacobians J;
  Eigen::Map<Vec2> r(residuals);
  r = reprojectionResidual(*host_, *sight_, poseFrom(x[0]), poseFrom(x[1]), T_B_C_, landmark,
                           camera_, jacobians && !elsewhere ? &J : nullptr);
  if (!jacobians) return true;
  if (elsewhere) {
    reprojectionResidual(*host_, *sight_, poseFrom(lin_i_ ? lin_i_ : x[0]),
                         poseFrom(lin_j_ ? lin_j_ : x[1]), T_B_C_, landmark, camera_, &J);
  }
  lift(J.pose_i, jacobians[0]);
  lift(J.pose_j, jacobians[1]);
  if (jacobians[2]) (Eigen::Map<RowMajor2x3>(jacobians[2])) = J.landmark;
  return true;
}

bool ReprojectionCalibrationFactor::Evaluate(double const* const* x, double* residuals,
                                             double** jacobians) const {
  const Vec3 landmark(x[3][0], x[3][1], x[3][2]);
  const Pose T_B_C = poseFrom(x[2]);
  const CameraVector camera(x[4]);
  const bool elsewhere = lin_i_ || lin_j_;
  ReprojectionJacobians J;
  Eigen::Map<Vec2> r(residuals);
  r = reprojectionResidual(*host_, *sight_, poseFrom(x[0]), poseFrom(x[1]), T_B_C, landmark, camera,
                           jacobians && !elsewhere ? &J : nullptr);
  if (!jacobians) return true;
  if (elsewhere) {
    reprojectionResidual(*host_, *sight_, poseFrom(lin_i_ ? lin_i_ : x[0]),
                         poseFrom(lin_j_ ? lin_j_ : x[1]), T_B_C, landmark, camera, &J);
  }
  lift(J.pose_i, jacobians[0]);
  lift(J.pose_j, jacobians[1]);
  lift(J.extrinsic, jacobians[2]);
  if (jacobians[3]) (Eigen::Map<RowMajor2x3>(jacobians[3])) = J.landmark;
  if (jacobians[4]) (Eigen::Map<RowMajor2x6>(jacobians[4])) = J.camera;
  return true;
}

bool PointSightFactor::Evaluate(double const* const* x, double* residuals,
                                double** jacobians) const {
  const Pose T = poseFrom(x[0]);
  const Mat3 R_B_W = T.R().transpose();
  const Vec3 p_B = R_B_W * (p_W_ - T.p);
  const Vec3 s = R_C_B_ * (p_B - p_B_C_);
  const double n = std::max(s.norm(), 1e-9);
  const Vec3 su = s / n;
  Eigen::Map<Vec2> r(residuals);
  r = weight_ * (su - bearing_);
  if (jacobians && jacobians[0]) {
    const Mat23 D = (weight_ - (weight_ * su) * su.transpose()) / n * R_C_B_;
    Eigen::Matrix<double, 2, 6> J;
    J.leftCols<3>() = -D * R_B_W;
    J.rightCols<3>() = D * hat(p_B);
    lift(J, jacobians[0]);
  }
  return true;
}

bool HostSightFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  Eigen::Map<Vec2>(residuals).noalias() = J_ * Vec2(x[0][0], x[0][1]);
  if (jacobians && jacobians[0]) {
    Eigen::Map<RowMajor2x3> M(jacobians[0]);
    M.leftCols<2>() = J_;
    M.col(2).setZero();
  }
  return true;
}

}  // namespace vir::factors
