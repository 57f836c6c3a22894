#pragma once
/// Inertial residual between two frames (paper, section "IMU factor").
#include <ceres/sized_cost_function.h>

#include "vir/imu/preintegration.h"

namespace vir::factors {

/// Residual [15], whitened, in the order of ImuErrorIndex.
///   r_p  = R_i^T (p_j - p_i - v_i dt - g dt^2/2) - dp
///   r_th = Log(dq^-1 q_i^-1 q_j)
///   r_v  = R_i^T (v_j - v_i - g dt) - dv
///   r_b  = b_j - b_i
/// Keeps a reference to the preintegration: it must outlive this.
class ImuResidual {
 public:
  ImuResidual(const imu::Preintegration& preintegration, double gravity);
  /// First-estimate Jacobians: where a pointer is not null, Jacobians are evaluated there instead
  /// of at the current value (order as the parameters). The residual is always the current one.
  void linearizeAt(const double* pose_i, const double* sb_i, const double* pose_j,
                   const double* sb_j);
  /// `x`: pose i, speed_bias i, pose j, speed_bias j. `jacobians`: of these and, if
  /// `by_intrinsics`, of the intrinsics; may be nullptr, each may be nullptr.
  void evaluate(double const* const* x, const imu::ImuIntrinsics& intrinsics, double* residuals,
                double** jacobians, bool by_intrinsics) const;

 private:
  void residual(double const* const* x, const imu::ImuIntrinsics& intrinsics, imu::Vec15* r) const;
  void jacobians(double const* const* x, const imu::ImuIntrinsics& intrinsics, double** out,
                 bool by_intrinsics) const;
  const imu::Preintegration& pre_;
  Vec3 g_W_;
  imu::Mat15 sqrt_info_;
  const double* lin_[4] = {nullptr, nullptr, nullptr, nullptr};
};

/// What both factors below share: the residual and where its Jacobians are evaluated. `Further` are
/// the sizes of parameters after pose i, speed_bias i, pose j, speed_bias j.
template <int... Further>
class ImuFactorBase : public ceres::SizedCostFunction<15, 7, 9, 7, 9, Further...> {
 public:
  /// See ImuResidual::linearizeAt.
  void linearizeAt(const double* pose_i, const double* sb_i, const double* pose_j,
                   const double* sb_j) {
    residual_.linearizeAt(pose_i, sb_i, pose_j, sb_j);
  }

 protected:
  ImuFactorBase(const imu::Preintegration& preintegration, double gravity)
      : residual_(preintegration, gravity) {}
  ImuResidual residual_;
};

/// Parameters: pose i, speed_bias i, pose j, speed_bias j. The IMU's intrinsics are fixed.
class ImuFactor final : public ImuFactorBase<> {
 public:
  ImuFactor(const imu::Preintegration& preintegration, double gravity)
      : ImuFactor(preintegration, gravity, preintegration.intrinsics()) {}
  ImuFactor(const imu::Preintegration& preintegration, double gravity,
            const imu::ImuIntrinsics& intrinsics)
      : ImuFactorBase(preintegration, gravity), intrinsics_(intrinsics) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  imu::ImuIntrinsics intrinsics_;
};

/// Parameters: pose i, speed_bias i, pose j, speed_bias j, intrinsics (they are estimated).
class ImuCalibrationFactor final : public ImuFactorBase<imu::kImuIntrinsicsSize> {
 public:
  ImuCalibrationFactor(const imu::Preintegration& preintegration, double gravity)
      : ImuFactorBase(preintegration, gravity) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;
};

}  // namespace vir::factors
