#pragma once
/// Vision residual: a landmark seen in another frame than its host (paper, section "Vision
/// Factor").
#include <ceres/sized_cost_function.h>

#include "vir/factors/camera_parameters.h"
#include "vir/geometry/pose.h"

namespace vir::factors {

using Mat32 = Eigen::Matrix<double, 3, 2>;

/// Orthonormal basis of the tangent plane at a unit vector.
Mat32 tangentBasis(const Vec3& unit);

/// One sight of a landmark. `weight` = (projection Jacobian at the bearing) / sigma_px, so that
/// weight * (predicted bearing - bearing) is the whitened pixel residual to first order, for any
/// camera model, without evaluating its distortion again.
struct Sight : CameraRay {
  Mat23 weight = Mat23::Zero();
};

/// The landmark on the host's ray: direction d = bearing + basis (u, v), inverse distance rho;
/// p_C = d / rho. u, v carry the noise of the host's own sight.
struct HostRay : CameraRay {
  Mat32 basis = Mat32::Zero();
};

/// All Jacobians of one reprojection; those not wanted are still computed (they share everything).
struct ReprojectionJacobians {
  Eigen::Matrix<double, 2, 6> pose_i, pose_j, extrinsic;
  Mat23 landmark;
  Eigen::Matrix<double, 2, kCameraParameters> camera;
};

/// Where host and sight are of two cameras, or both of one: a Jacobian for either.
struct RigJacobians {
  Eigen::Matrix<double, 2, 6> pose_i, pose_j, extrinsic_i, extrinsic_j;
  Mat23 landmark;
  Eigen::Matrix<double, 2, kCameraParameters> camera_i, camera_j;
};

/// How what camera i sees at frame i stands in camera j: s_Cj = R_Cj_Ci d_Ci + rho t_Cj, for a
/// point at d / rho in camera i; and what Jacobians need. The same for all sights of two frames.
struct SightGeometry {
  SightGeometry() = default;
  SightGeometry(const Pose& T_W_Bi, const Pose& T_W_Bj, const Pose& T_B_C)
      : SightGeometry(T_W_Bi, T_W_Bj, T_B_C, T_B_C) {}
  SightGeometry(const Pose& T_W_Bi, const Pose& T_W_Bj, const Pose& T_B_Ci, const Pose& T_B_Cj);
  Mat3 R_Cj_Ci, R_Cj_Bi, R_Cj_W, R_Ci_B, R_Cj_B;
  Vec3 t_Cj, p_B_Ci, p_B_Cj;
};

/// Whitened residual [2] of the landmark hosted in frame i, seen in frame j. Scaled by the inverse
/// distance throughout, so that points at infinity (rho = 0) are regular.
Vec2 reprojectionResidual(const HostRay& host, const Sight& sight, const Pose& T_W_Bi,
                          const Pose& T_W_Bj, const Pose& T_B_C, const Vec3& landmark,
                          const CameraVector& camera, ReprojectionJacobians* J);
Vec2 reprojectionResidual(const HostRay& host, const Sight& sight, const SightGeometry& between,
                          const Vec3& landmark, const CameraVector& camera,
                          ReprojectionJacobians* J);

/// Likewise of the landmark hosted by one camera and seen by another, or by the same.
Vec2 rigResidual(const HostRay& host, const Sight& sight, const SightGeometry& between,
                 const Vec3& landmark, const CameraVector& camera_i, const CameraVector& camera_j,
                 RigJacobians* J);

/// What both factors below share: which sight it is, and where its Jacobians are evaluated. Refers
/// to host and sight, of which a window has thousands: they must outlive it.
template <int... Sizes>
class ReprojectionFactorBase : public ceres::SizedCostFunction<2, Sizes...> {
 public:
  /// First-estimate Jacobians, see ImuFactor::linearizeAt.
  void linearizeAt(const double* pose_i, const double* pose_j) {
    lin_i_ = pose_i;
    lin_j_ = pose_j;
  }
  const HostRay& host() const { return *host_; }
  const Sight& sight() const { return *sight_; }
  /// Where Jacobians are evaluated; nullptr: at the current value.
  const double* linI() const { return lin_i_; }
  const double* linJ() const { return lin_j_; }

 protected:
  ReprojectionFactorBase() = default;
  ReprojectionFactorBase(const HostRay& host, const Sight& sight) : host_(&host), sight_(&sight) {}
  void setSight(const HostRay& host, const Sight& sight) {
    host_ = &host;
    sight_ = &sight;
    lin_i_ = lin_j_ = nullptr;
  }
  const HostRay* host_ = nullptr;
  const Sight* sight_ = nullptr;
  const double* lin_i_ = nullptr;
  const double* lin_j_ = nullptr;
};

/// Parameters: pose i, pose j, landmark. Calibration fixed.
class ReprojectionFactor final : public ReprojectionFactorBase<7, 7, 3> {
 public:
  /// To be set.
  ReprojectionFactor() = default;
  ReprojectionFactor(const HostRay& host, const Sight& sight, const Pose& T_B_C,
                     const CameraVector& camera)
      : ReprojectionFactorBase(host, sight), T_B_C_(T_B_C), camera_(camera) {}
  void set(const HostRay& host, const Sight& sight, const Pose& T_B_C, const CameraVector& camera) {
    setSight(host, sight);
    T_B_C_ = T_B_C;
    camera_ = camera;
  }
  const Pose& extrinsics() const { return T_B_C_; }
  const CameraVector& camera() const { return camera_; }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Pose T_B_C_;
  CameraVector camera_;
};

/// Parameters: pose i, pose j, extrinsic, landmark, camera (its calibration is estimated).
class ReprojectionCalibrationFactor final
    : public ReprojectionFactorBase<7, 7, 7, 3, kCameraParameters> {
 public:
  /// To be set.
  ReprojectionCalibrationFactor() = default;
  ReprojectionCalibrationFactor(const HostRay& host, const Sight& sight)
      : ReprojectionFactorBase(host, sight) {}
  void set(const HostRay& host, const Sight& sight) { setSight(host, sight); }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;
};

/// A landmark hosted by one camera of a rig and seen by another. Parameters: the landmark; pose i
/// and pose j if the two are of different frames (of one they cancel: there is no such parameter);
/// then, if the calibration is estimated, extrinsic and camera of the host and those of the sight.
class RigReprojectionFactor final : public ceres::CostFunction {
 public:
  /// Calibration fixed, as given here.
  struct Known {
    Pose T_B_Ci, T_B_Cj;
    CameraVector camera_i, camera_j;
  };
  /// To be set.
  RigReprojectionFactor() = default;
  RigReprojectionFactor(const HostRay& host, const Sight& sight, bool same_frame,
                        const Known* known = nullptr, const double* lin_i = nullptr,
                        const double* lin_j = nullptr) {
    set(host, sight, same_frame, known, lin_i, lin_j);
  }
  /// Refers to host and sight: they must outlive it. Without `known` it has the calibration's
  /// parameters. `lin_i`, `lin_j`: where Jacobians are evaluated, nullptr: at the current value.
  void set(const HostRay& host, const Sight& sight, bool same_frame, const Known* known,
           const double* lin_i, const double* lin_j);
  const HostRay& host() const { return *host_; }
  const Sight& sight() const { return *sight_; }
  bool sameFrame() const { return same_frame_; }
  bool calibrated() const { return calibrated_; }
  const double* linI() const { return lin_i_; }
  const double* linJ() const { return lin_j_; }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Vec2 evaluateAt(double const* const* x, bool linearized, RigJacobians* J) const;

  const HostRay* host_ = nullptr;
  const Sight* sight_ = nullptr;
  bool same_frame_ = false, calibrated_ = false;
  Known known_;
  const double *lin_i_ = nullptr, *lin_j_ = nullptr;
};

/// A known point p_W seen from a frame; whitened residual [2]. Parameter: pose. Calibration fixed.
class PointSightFactor final : public ceres::SizedCostFunction<2, 7> {
 public:
  /// To be set.
  PointSightFactor() = default;
  PointSightFactor(const Vec3& p_W, const Sight& sight, const Pose& T_B_C) {
    set(p_W, sight.bearing, sight.weight, T_B_C);
  }
  void set(const Vec3& p_W, const Vec3& bearing, const Mat23& weight, const Pose& T_B_C) {
    p_W_ = p_W;
    bearing_ = bearing;
    weight_ = weight;
    R_C_B_ = T_B_C.R().transpose();
    p_B_C_ = T_B_C.p;
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Vec3 p_W_, bearing_;
  Mat23 weight_;
  Mat3 R_C_B_;
  Vec3 p_B_C_;
};

/// The host's own sight: whitened residual [2] = weight * basis * (u, v). Parameter: landmark.
class HostSightFactor final : public ceres::SizedCostFunction<2, 3> {
 public:
  /// To be set.
  HostSightFactor() = default;
  HostSightFactor(const HostRay& host, const Mat23& weight) { set(host, weight); }
  void set(const HostRay& host, const Mat23& weight) { J_ = weight * host.basis; }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Eigen::Matrix2d J_;
};

}  // namespace vir::factors
