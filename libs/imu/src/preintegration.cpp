#include "vir/imu/preintegration.h"

#include <Eigen/Cholesky>
#include <stdexcept>
#include <string>

#include "vir/core/option_check.h"

namespace vir::imu {
namespace {
/// Position noise of the integration rule itself [m/sqrt(s)]: keeps the covariance of a single step
/// invertible (its position and velocity errors are otherwise fully correlated).
constexpr double kIntegrationNoise = 1e-5;
}  // namespace

void describe(OptionVisitor& v, ImuNoise& o) {
  v.section("Imu", "Noise of the IMU; `import` writes the data sheet's values beside the rawlog");
  v.value("gyro_noise_density", o.gyro_noise_density, {1e-7, 1.0},
          "gyro white noise [rad/s/sqrt(Hz)]");
  v.value("acc_noise_density", o.acc_noise_density, {1e-6, 10.0},
          "accelerometer white noise [m/s^2/sqrt(Hz)]");
  v.value("gyro_random_walk", o.gyro_random_walk, {1e-9, 1.0},
          "gyro bias random walk [rad/s^2/sqrt(Hz)]");
  v.value("acc_random_walk", o.acc_random_walk, {1e-9, 10.0},
          "accelerometer bias random walk [m/s^3/sqrt(Hz)]");
  v.value("noise_scale", o.noise_scale, {0.1, 1000.0},
          "white noise is multiplied by this: a data sheet knows no vibration");
  v.value("gravity_mps2", o.gravity_mps2, {0.1, 30.0}, "local gravity [m/s^2]");
}

void ImuNoise::validate() const { checkBounds(*this); }

Preintegration::Preintegration(const ImuNoise& noise, const Vec3& bias_gyro, const Vec3& bias_acc,
                               const ImuIntrinsics& intrinsics)
    : noise_(noise), bg_(bias_gyro), ba_(bias_acc), intrinsics_(intrinsics) {
  steps_.reserve(16);
}

void Preintegration::clear() {
  dt_ = 0;
  dq_.setIdentity();
  dp_.setZero();
  dv_.setZero();
  jac_.setZero();
  jac_intrinsics_.setZero();
  cov_.setZero();
}

void Preintegration::integrate(const ImuSample& a, const ImuSample& b, double noise_factor) {
  if (b.t <= a.t || !a.gyro.allFinite() || !a.acc.allFinite() || !b.gyro.allFinite() ||
      !b.acc.allFinite()) {
    throw std::invalid_argument("Preintegration: readings must be finite and ordered in time, at " +
                                std::to_string(a.t) + " ns and " + std::to_string(b.t) + " ns");
  }
  steps_.push_back({toSeconds(b.t - a.t), noise_factor, a.gyro, a.acc, b.gyro, b.acc});
  propagate(steps_.back());
}

void Preintegration::append(const Preintegration& next) {
  steps_.reserve(steps_.size() + next.steps_.size());
  for (const Step& s : next.steps_) {
    steps_.push_back(s);
    propagate(s);
  }
}

void Preintegration::relinearise(const Vec3& bias_gyro, const Vec3& bias_acc,
                                 const ImuIntrinsics& intrinsics) {
  bg_ = bias_gyro;
  ba_ = bias_acc;
  intrinsics_ = intrinsics;
  clear();
  for (const Step& s : steps_) propagate(s);
}

Vec3 Preintegration::rateOf(const Vec3& reading) const {
  const Vec3 w = reading - bg_;
  return w + intrinsics_.segment<3>(kGyroGain).cwiseProduct(w) +
         intrinsics_.segment<3>(kGyroAxes).cross(w);
}

Vec3 Preintegration::firstRate() const {
  return steps_.empty() ? Vec3(Vec3::Zero()) : rateOf(steps_.front().gyro0);
}

Vec3 Preintegration::lastRate() const {
  return steps_.empty() ? Vec3(Vec3::Zero()) : rateOf(steps_.back().gyro1);
}

void Preintegration::propagate(const Step& s) {
  const double dt = s.dt;
  const Vec3 reading = 0.5 * (s.gyro0 + s.gyro1);
  const Vec3 w_biased = reading - bg_, a0_biased = s.acc0 - ba_, a1_biased = s.acc1 - ba_;
  const Vec3 acc_gain = Vec3::Ones() + intrinsics_.segment<3>(kAccGain);
  const Vec3 w = rateOf(reading);
  const Vec3 a0 = acc_gain.cwiseProduct(a0_biased);
  const Vec3 a1 = acc_gain.cwiseProduct(a1_biased);
  Mat3 M = hat(intrinsics_.segment<3>(kGyroAxes));  // d rate / d reading
  M.diagonal() += Vec3::Ones() + intrinsics_.segment<3>(kGyroGain);
  const Mat3 R0 = dq_.toRotationMatrix();
  const Quat dq_step = expQuat(w * dt);
  const Quat q1 = (dq_ * dq_step).normalized();
  const Mat3 R1 = q1.toRotationMatrix();
  const Vec3 a = 0.5 * (R0 * a0 + R1 * a1);

  // Error propagation: theta' = A theta + B dw; the mean acceleration depends on theta and theta'.
  const Mat3 A = dq_step.toRotationMatrix().transpose();
  const Mat3 B = rightJacobianSO3(w * dt) * dt;
  const Mat3 G0 = -0.5 * R0 * hat(a0);
  const Mat3 G1 = -0.5 * R1 * hat(a1);
  const Mat3 a_theta = G0 + G1 * A;
  const Mat3 a_bg = -G1 * B * M;
  const Mat3 a_ba = -0.5 * (R0 + R1) * acc_gain.asDiagonal();

  Mat15 F = Mat15::Identity();
  F.block<3, 3>(kP, kTheta) = 0.5 * dt * dt * a_theta;
  F.block<3, 3>(kP, kV) = Mat3::Identity() * dt;
  F.block<3, 3>(kP, kBg) = 0.5 * dt * dt * a_bg;
  F.block<3, 3>(kP, kBa) = 0.5 * dt * dt * a_ba;
  F.block<3, 3>(kTheta, kTheta) = A;
  F.block<3, 3>(kTheta, kBg) = -B * M;
  F.block<3, 3>(kV, kTheta) = dt * a_theta;
  F.block<3, 3>(kV, kBg) = dt * a_bg;
  F.block<3, 3>(kV, kBa) = dt * a_ba;

  jac_ = F.topLeftCorner<9, 9>() * jac_ + F.topRightCorner<9, 6>();
  Mat9 N;  // by the intrinsics
  Eigen::Matrix<double, 3, 9> a_x;
  N.block<3, 3>(kTheta, kGyroGain) = B * w_biased.asDiagonal();
  N.block<3, 3>(kTheta, kGyroAxes) = -B * hat(w_biased);
  N.block<3, 3>(kTheta, kAccGain).setZero();
  a_x.leftCols<6>() = G1 * N.block<3, 6>(kTheta, 0);
  a_x.rightCols<3>() =
      0.5 * R0 * Mat3(a0_biased.asDiagonal()) + 0.5 * R1 * Mat3(a1_biased.asDiagonal());
  N.middleRows<3>(kP) = 0.5 * dt * dt * a_x;
  N.middleRows<3>(kV) = dt * a_x;
  jac_intrinsics_ = F.topLeftCorner<9, 9>() * jac_intrinsics_ + N;
  growCovariance(F, s);

  dp_ += dv_ * dt + 0.5 * a * dt * dt;
  dv_ += a * dt;
  dq_ = q1;
  dt_ += dt;
}

void Preintegration::growCovariance(const Mat15& F, const Step& s) {
  const double dt = s.dt;
  cov_ = F * cov_ * F.transpose();
  // White noise of density s has variance s^2/dt over a step: it enters where the bias enters.
  const double scale = noise_.noise_scale * s.noise_factor;
  const double var_g = std::pow(noise_.gyro_noise_density * scale, 2) / dt;
  const double var_a = std::pow(noise_.acc_noise_density * scale, 2) / dt;
  const Eigen::Matrix<double, 9, 3> Ng = F.block<9, 3>(0, kBg);
  const Eigen::Matrix<double, 9, 3> Na = F.block<9, 3>(0, kBa);
  cov_.topLeftCorner<9, 9>() += var_g * Ng * Ng.transpose() + var_a * Na * Na.transpose();
  cov_.diagonal().segment<3>(kP).array() += kIntegrationNoise * kIntegrationNoise * dt;
  cov_.diagonal().segment<3>(kBg).array() += std::pow(noise_.gyro_random_walk, 2) * dt;
  cov_.diagonal().segment<3>(kBa).array() += std::pow(noise_.acc_random_walk, 2) * dt;
}

Mat15 Preintegration::sqrtInformation() const {
  const Eigen::LLT<Mat15> llt(cov_);
  if (llt.info() != Eigen::Success) {
    throw std::runtime_error("Preintegration: covariance over " + std::to_string(dt_) +
                             " s is not positive definite");
  }
  return llt.matrixL().solve(Mat15::Identity());
}

Quat Preintegration::correctedDq(const Vec3& bg, const ImuIntrinsics& x) const {
  const Vec3 shift = jac_.block<3, 3>(kTheta, 0) * (bg - bg_) +
                     jac_intrinsics_.middleRows<3>(kTheta) * (x - intrinsics_);
  return (dq_ * expQuat(shift)).normalized();
}

Vec3 Preintegration::correctedDp(const Vec3& bg, const Vec3& ba, const ImuIntrinsics& x) const {
  return dp_ + jac_.block<3, 3>(kP, 0) * (bg - bg_) + jac_.block<3, 3>(kP, 3) * (ba - ba_) +
         jac_intrinsics_.middleRows<3>(kP) * (x - intrinsics_);
}

Vec3 Preintegration::correctedDv(const Vec3& bg, const Vec3& ba, const ImuIntrinsics& x) const {
  return dv_ + jac_.block<3, 3>(kV, 0) * (bg - bg_) + jac_.block<3, 3>(kV, 3) * (ba - ba_) +
         jac_intrinsics_.middleRows<3>(kV) * (x - intrinsics_);
}

}  // namespace vir::imu
