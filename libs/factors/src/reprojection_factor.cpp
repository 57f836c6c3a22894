#include "vir/factors/reprojection_factor.h"

#include <algorithm>
#include <cmath>
#include <vector>

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

SightGeometry::SightGeometry(const Pose& T_W_Bi, const Pose& T_W_Bj, const Pose& T_B_Ci,
                             const Pose& T_B_Cj)
    : p_B_Ci(T_B_Ci.p), p_B_Cj(T_B_Cj.p) {
  const Mat3 R_B_Ci = T_B_Ci.R();
  const Mat3 R_W_Bi = T_W_Bi.R();
  R_Ci_B = R_B_Ci.transpose();
  R_Cj_B = T_B_Cj.R().transpose();
  R_Cj_W = R_Cj_B * T_W_Bj.R().transpose();
  R_Cj_Bi = R_Cj_W * R_W_Bi;
  R_Cj_Ci = R_Cj_Bi * R_B_Ci;
  t_Cj = R_Cj_W * (R_W_Bi * p_B_Ci + T_W_Bi.p - T_W_Bj.p) - R_Cj_B * p_B_Cj;
}

namespace {

/// The parts of a residual that all Jacobians need.
struct Bent {
  Vec3 d, s, su;
  double n = 1;
};

Bent bentRay(const HostRay& host, const SightGeometry& g, const Vec3& landmark,
             const CameraVector& camera) {
  Bent out;
  out.d = host.bearingAt(camera) + host.basis * landmark.head<2>();
  out.s = g.R_Cj_Ci * out.d + landmark[2] * g.t_Cj;
  out.n = std::max(out.s.norm(), 1e-9);
  out.su = out.s / out.n;
  return out;
}

/// Those of poses and landmark; `J` is of either kind. What the calibration's need.
struct Chain {
  Mat23 D, D_Bj, D_Bi, D_Ci;
};

template <typename Jacobians>
Chain poseAndLandmark(const HostRay& host, const Sight& sight, const SightGeometry& g, double rho,
                      const Bent& b, Jacobians* J) {
  Chain c;
  c.D = (sight.weight - (sight.weight * b.su) * b.su.transpose()) / b.n;
  c.D_Bj = c.D * g.R_Cj_B;
  c.D_Bi = c.D * g.R_Cj_Bi;
  c.D_Ci = c.D * g.R_Cj_Ci;
  const Vec3 x_Bi = g.R_Ci_B.transpose() * b.d + rho * g.p_B_Ci;
  const Vec3 x_Bj = g.R_Cj_B.transpose() * b.s + rho * g.p_B_Cj;
  J->pose_i.template leftCols<3>() = rho * (c.D * g.R_Cj_W);
  J->pose_i.template rightCols<3>() = -c.D_Bi * hat(x_Bi);
  J->pose_j.template leftCols<3>() = -J->pose_i.template leftCols<3>();
  J->pose_j.template rightCols<3>() = c.D_Bj * hat(x_Bj);
  J->landmark.template leftCols<2>() = c.D_Ci * host.basis;
  J->landmark.col(2) = c.D * g.t_Cj;
  return c;
}

}  // namespace

Vec2 reprojectionResidual(const HostRay& host, const Sight& sight, const Pose& T_W_Bi,
                          const Pose& T_W_Bj, const Pose& T_B_C, const Vec3& landmark,
                          const CameraVector& camera, ReprojectionJacobians* J) {
  return reprojectionResidual(host, sight, SightGeometry(T_W_Bi, T_W_Bj, T_B_C), landmark, camera,
                              J);
}

Vec2 reprojectionResidual(const HostRay& host, const Sight& sight, const SightGeometry& g,
                          const Vec3& landmark, const CameraVector& camera,
                          ReprojectionJacobians* J) {
  const Bent b = bentRay(host, g, landmark, camera);
  const Vec2 r = sight.weight * (b.su - sight.bearingAt(camera));
  if (!J) return r;
  const double rho = landmark[2];
  const Chain c = poseAndLandmark(host, sight, g, rho, b, J);
  J->extrinsic.leftCols<3>() = rho * (c.D_Bi - c.D_Bj);
  J->extrinsic.rightCols<3>() = c.D * hat(b.s) - c.D_Ci * hat(b.d);
  J->camera = c.D_Ci * host.by_camera - sight.weight * sight.by_camera;
  return r;
}

Vec2 rigResidual(const HostRay& host, const Sight& sight, const SightGeometry& g,
                 const Vec3& landmark, const CameraVector& camera_i, const CameraVector& camera_j,
                 RigJacobians* J) {
  const Bent b = bentRay(host, g, landmark, camera_i);
  const Vec2 r = sight.weight * (b.su - sight.bearingAt(camera_j));
  if (!J) return r;
  const double rho = landmark[2];
  const Chain c = poseAndLandmark(host, sight, g, rho, b, J);
  J->extrinsic_i.leftCols<3>() = rho * c.D_Bi;
  J->extrinsic_i.rightCols<3>() = -c.D_Ci * hat(b.d);
  J->extrinsic_j.leftCols<3>() = -rho * c.D_Bj;
  J->extrinsic_j.rightCols<3>() = c.D * hat(b.s);
  J->camera_i = c.D_Ci * host.by_camera;
  J->camera_j = -sight.weight * sight.by_camera;
  return r;
}

void RigReprojectionFactor::set(const HostRay& host, const Sight& sight, bool same_frame,
                                const Known* known, const double* lin_i, const double* lin_j) {
  host_ = &host;
  sight_ = &sight;
  same_frame_ = same_frame;
  calibrated_ = known == nullptr;
  lin_i_ = lin_i;
  lin_j_ = lin_j;
  if (known) known_ = *known;
  set_num_residuals(2);
  std::vector<int>& sizes = *mutable_parameter_block_sizes();
  sizes = {3};
  if (!same_frame) sizes.insert(sizes.end(), {7, 7});
  if (calibrated_) sizes.insert(sizes.end(), {7, kCameraParameters, 7, kCameraParameters});
}

Vec2 RigReprojectionFactor::evaluateAt(double const* const* x, bool linearized,
                                       RigJacobians* J) const {
  Known now = known_;
  if (calibrated_) {
    const double* const* k = x + (same_frame_ ? 1 : 3);
    now.T_B_Ci = poseFrom(k[0]);
    now.camera_i = CameraVector(k[1]);
    now.T_B_Cj = poseFrom(k[2]);
    now.camera_j = CameraVector(k[3]);
  }
  const double *i = nullptr, *j = nullptr;
  if (!same_frame_) {
    i = linearized && lin_i_ ? lin_i_ : x[1];
    j = linearized && lin_j_ ? lin_j_ : x[2];
  }
  const SightGeometry g(i ? poseFrom(i) : Pose(), j ? poseFrom(j) : Pose(), now.T_B_Ci, now.T_B_Cj);
  return rigResidual(*host_, *sight_, g, Vec3(x[0]), now.camera_i, now.camera_j, J);
}

bool RigReprojectionFactor::Evaluate(double const* const* x, double* residuals,
                                     double** jacobians) const {
  const bool elsewhere = !same_frame_ && (lin_i_ || lin_j_);
  RigJacobians J;
  Eigen::Map<Vec2> r(residuals);
  r = evaluateAt(x, false, jacobians && !elsewhere ? &J : nullptr);
  if (!jacobians) return true;
  if (elsewhere) evaluateAt(x, true, &J);
  if (jacobians[0]) (Eigen::Map<RowMajor2x3>(jacobians[0])) = J.landmark;
  if (!same_frame_) {
    lift(J.pose_i, jacobians[1]);
    lift(J.pose_j, jacobians[2]);
  }
  if (!calibrated_) return true;
  double** k = jacobians + (same_frame_ ? 1 : 3);
  lift(J.extrinsic_i, k[0]);
  if (k[1]) (Eigen::Map<RowMajor2x6>(k[1])) = J.camera_i;
  lift(J.extrinsic_j, k[2]);
  if (k[3]) (Eigen::Map<RowMajor2x6>(k[3])) = J.camera_j;
  return true;
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
