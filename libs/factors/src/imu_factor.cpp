#include "vir/factors/imu_factor.h"

#include "vir/factors/pose_manifold.h"

namespace vir::factors {
namespace {
using RowMajor15x7 = Eigen::Matrix<double, 15, 7, Eigen::RowMajor>;
using RowMajor15x9 = Eigen::Matrix<double, 15, 9, Eigen::RowMajor>;
using ByIntrinsics = Eigen::Matrix<double, 15, imu::kImuIntrinsicsSize, Eigen::RowMajor>;

Vec3 vec(const double* x) { return {x[0], x[1], x[2]}; }
}  // namespace

ImuResidual::ImuResidual(const imu::Preintegration& preintegration, double gravity)
    : pre_(preintegration), g_W_(0, 0, -gravity), sqrt_info_(preintegration.sqrtInformation()) {}

void ImuResidual::linearizeAt(const double* pose_i, const double* sb_i, const double* pose_j,
                              const double* sb_j) {
  lin_[0] = pose_i;
  lin_[1] = sb_i;
  lin_[2] = pose_j;
  lin_[3] = sb_j;
}

void ImuResidual::residual(double const* const* x, const imu::ImuIntrinsics& k,
                           imu::Vec15* r) const {
  const Pose Ti = poseFrom(x[0]), Tj = poseFrom(x[2]);
  const Vec3 vi = vec(x[1]), bgi = vec(x[1] + 3), bai = vec(x[1] + 6);
  const Vec3 vj = vec(x[3]), bgj = vec(x[3] + 3), baj = vec(x[3] + 6);
  const double dt = pre_.dt();
  const Quat qit = Ti.q.conjugate();
  r->segment<3>(imu::kP) =
      qit * (Tj.p - Ti.p - vi * dt - 0.5 * g_W_ * dt * dt) - pre_.correctedDp(bgi, bai, k);
  r->segment<3>(imu::kTheta) = logQuat(pre_.correctedDq(bgi, k).conjugate() * (qit * Tj.q));
  r->segment<3>(imu::kV) = qit * (vj - vi - g_W_ * dt) - pre_.correctedDv(bgi, bai, k);
  r->segment<3>(imu::kBg) = bgj - bgi;
  r->segment<3>(imu::kBa) = baj - bai;
}

void ImuResidual::jacobians(double const* const* x, const imu::ImuIntrinsics& k, double** out,
                            bool by_intrinsics) const {
  const Pose Ti = poseFrom(x[0]), Tj = poseFrom(x[2]);
  const Vec3 vi = vec(x[1]), bgi = vec(x[1] + 3);
  const Vec3 vj = vec(x[3]);
  const double dt = pre_.dt();
  const Mat3 RiT = Ti.R().transpose();
  const imu::Mat9x6& B = pre_.biasJacobian();
  const Vec3 r_theta = logQuat(pre_.correctedDq(bgi, k).conjugate() * (Ti.q.conjugate() * Tj.q));
  const Mat3 Jr_inv = rightJacobianInverseSO3(r_theta);
  // dq(bg, k) = dq Exp(shift): its inverse stands on the left of the logarithm.
  const imu::Mat9& K = pre_.intrinsicsJacobian();
  const Vec3 shift = B.block<3, 3>(imu::kTheta, 0) * (bgi - pre_.biasGyro()) +
                     K.middleRows<3>(imu::kTheta) * (k - pre_.intrinsics());
  const Mat3 by_shift = -Jr_inv * expSO3(-r_theta) * rightJacobianSO3(shift);
  if (out[0]) {
    Eigen::Map<RowMajor15x7> J(out[0]);
    RowMajor15x7 U = RowMajor15x7::Zero();
    U.block<3, 3>(imu::kP, 0) = -RiT;
    U.block<3, 3>(imu::kP, 3) = hat(RiT * (Tj.p - Ti.p - vi * dt - 0.5 * g_W_ * dt * dt));
    U.block<3, 3>(imu::kTheta, 3) = -Jr_inv * (Tj.q.conjugate() * Ti.q).toRotationMatrix();
    U.block<3, 3>(imu::kV, 3) = hat(RiT * (vj - vi - g_W_ * dt));
    J.noalias() = sqrt_info_ * U;
  }
  if (out[1]) {
    Eigen::Map<RowMajor15x9> J(out[1]);
    RowMajor15x9 U = RowMajor15x9::Zero();
    U.block<3, 3>(imu::kP, 0) = -RiT * dt;
    U.block<3, 6>(imu::kP, 3) = -B.block<3, 6>(imu::kP, 0);
    U.block<3, 3>(imu::kTheta, 3) = by_shift * B.block<3, 3>(imu::kTheta, 0);
    U.block<3, 3>(imu::kV, 0) = -RiT;
    U.block<3, 6>(imu::kV, 3) = -B.block<3, 6>(imu::kV, 0);
    U.block<6, 6>(imu::kBg, 3) = -Eigen::Matrix<double, 6, 6>::Identity();
    J.noalias() = sqrt_info_ * U;
  }
  if (out[2]) {
    Eigen::Map<RowMajor15x7> J(out[2]);
    RowMajor15x7 U = RowMajor15x7::Zero();
    U.block<3, 3>(imu::kP, 0) = RiT;
    U.block<3, 3>(imu::kTheta, 3) = Jr_inv;
    J.noalias() = sqrt_info_ * U;
  }
  if (out[3]) {
    Eigen::Map<RowMajor15x9> J(out[3]);
    RowMajor15x9 U = RowMajor15x9::Zero();
    U.block<3, 3>(imu::kV, 0) = RiT;
    U.block<6, 6>(imu::kBg, 3).setIdentity();
    J.noalias() = sqrt_info_ * U;
  }
  if (by_intrinsics && out[4]) {
    Eigen::Map<ByIntrinsics> J(out[4]);
    ByIntrinsics U = ByIntrinsics::Zero();
    U.middleRows<3>(imu::kP) = -K.middleRows<3>(imu::kP);
    U.middleRows<3>(imu::kTheta) = by_shift * K.middleRows<3>(imu::kTheta);
    U.middleRows<3>(imu::kV) = -K.middleRows<3>(imu::kV);
    J.noalias() = sqrt_info_ * U;
  }
}

void ImuResidual::evaluate(double const* const* x, const imu::ImuIntrinsics& intrinsics,
                           double* residuals, double** J, bool by_intrinsics) const {
  imu::Vec15 r;
  residual(x, intrinsics, &r);
  Eigen::Map<imu::Vec15>(residuals).noalias() = sqrt_info_ * r;
  if (!J) return;
  const double* at[4];
  for (int k = 0; k < 4; ++k) at[k] = lin_[k] ? lin_[k] : x[k];
  jacobians(at, intrinsics, J, by_intrinsics);
}

bool ImuFactor::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  residual_.evaluate(x, intrinsics_, residuals, jacobians, false);
  return true;
}

bool ImuCalibrationFactor::Evaluate(double const* const* x, double* residuals,
                                    double** jacobians) const {
  residual_.evaluate(x, imu::ImuIntrinsics(x[4]), residuals, jacobians, true);
  return true;
}

}  // namespace vir::factors
