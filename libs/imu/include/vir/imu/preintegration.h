#pragma once
/// Preintegration of inertial readings between two images on the manifold (paper, section "IMU
/// factor"; Forster et al. 2017 for the manifold, mid-point rule).
#include <Eigen/StdVector>
#include <vector>

#include "vir/core/options.h"
#include "vir/types/imu_sample.h"

namespace vir::imu {

/// Continuous-time noise densities of an IMU.
struct ImuNoise {
  double gyro_noise_density = 1.7e-4;  ///< [rad/s/sqrt(Hz)]
  double acc_noise_density = 2.0e-3;   ///< [m/s^2/sqrt(Hz)]
  double gyro_random_walk = 2.0e-5;    ///< [rad/s^2/sqrt(Hz)]
  double acc_random_walk = 3.0e-3;     ///< [m/s^3/sqrt(Hz)]
  double noise_scale = 3.0;  ///< white noise is multiplied by this: vibration, timing, scale errors
  double gravity_mps2 = 9.81;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Imu].
void describe(OptionVisitor& v, ImuNoise& o);

/// Order of the error state: position, rotation, velocity, gyro bias, accelerometer bias.
enum ImuErrorIndex { kP = 0, kTheta = 3, kV = 6, kBg = 9, kBa = 12 };

using Mat9x6 = Eigen::Matrix<double, 9, 6>;
using Mat9 = Eigen::Matrix<double, 9, 9>;
using Mat15 = Eigen::Matrix<double, 15, 15>;
using Vec15 = Eigen::Matrix<double, 15, 1>;

/// What is wrong with an IMU beside its biases, all small: relative gain of the gyro per axis, the
/// gyro's axes against the accelerometer's (a rotation, [rad]), relative gain of the accelerometer.
///   rate = (I + diag(gyro_gain) + [axes]x) (reading - bias)
///   acceleration = (I + diag(acc_gain)) (reading - bias)
enum ImuIntrinsicsIndex { kGyroGain = 0, kGyroAxes = 3, kAccGain = 6 };
constexpr int kImuIntrinsicsSize = 9;
using ImuIntrinsics = Eigen::Matrix<double, kImuIntrinsicsSize, 1>;

/// Change of position, rotation and velocity from body frame i to j, in the frame of i, gravity
/// excluded; with covariance and first-order dependence on the biases and on the intrinsics.
class Preintegration {
 public:
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW
  /// Biases [rad/s], [m/s^2] and intrinsics are the linearisation point.
  Preintegration(const ImuNoise& noise, const Vec3& bias_gyro, const Vec3& bias_acc,
                 const ImuIntrinsics& intrinsics = ImuIntrinsics::Zero());

  /// Adds the interval between two readings (mid-point rule). Readings must be finite and
  /// `b.t > a.t`, else std::invalid_argument. `noise_factor` > 1 inflates the noise (a gap that was
  /// bridged by interpolation).
  void integrate(const ImuSample& a, const ImuSample& b, double noise_factor = 1.0);

  /// Appends what follows: the result reaches from this start to that end.
  void append(const Preintegration& next);

  /// Integrates the stored readings again around other biases and intrinsics.
  void relinearise(const Vec3& bias_gyro, const Vec3& bias_acc, const ImuIntrinsics& intrinsics);

  double dt() const { return dt_; }  ///< [s]
  const Quat& dq() const { return dq_; }
  const Vec3& dp() const { return dp_; }
  const Vec3& dv() const { return dv_; }
  const Vec3& biasGyro() const { return bg_; }
  const Vec3& biasAcc() const { return ba_; }
  /// d(p, theta, v)/d(bg, ba), 9x6.
  const Mat9x6& biasJacobian() const { return jac_; }
  const ImuIntrinsics& intrinsics() const { return intrinsics_; }
  /// d(p, theta, v)/d(intrinsics).
  const Mat9& intrinsicsJacobian() const { return jac_intrinsics_; }
  /// First and last reading of the gyro, bias and intrinsics taken off [rad/s].
  Vec3 firstRate() const;
  Vec3 lastRate() const;
  const Mat15& covariance() const { return cov_; }
  /// Square root of the inverse covariance: whitened residual = S * r.
  Mat15 sqrtInformation() const;

  /// Values corrected to other biases, to first order; intrinsics as they were integrated with.
  Quat correctedDq(const Vec3& bg) const { return correctedDq(bg, intrinsics_); }
  Vec3 correctedDp(const Vec3& bg, const Vec3& ba) const {
    return correctedDp(bg, ba, intrinsics_);
  }
  Vec3 correctedDv(const Vec3& bg, const Vec3& ba) const {
    return correctedDv(bg, ba, intrinsics_);
  }
  /// And to other intrinsics.
  Quat correctedDq(const Vec3& bg, const ImuIntrinsics& x) const;
  Vec3 correctedDp(const Vec3& bg, const Vec3& ba, const ImuIntrinsics& x) const;
  Vec3 correctedDv(const Vec3& bg, const Vec3& ba, const ImuIntrinsics& x) const;

  std::size_t size() const { return steps_.size(); }

 private:
  struct Step {
    double dt, noise_factor;
    Vec3 gyro0, acc0, gyro1, acc1;
  };
  void propagate(const Step& s);
  /// `F`: how the errors go on over `s`.
  void growCovariance(const Mat15& F, const Step& s);
  void clear();
  Vec3 rateOf(const Vec3& reading) const;

  ImuNoise noise_;
  Vec3 bg_, ba_;
  ImuIntrinsics intrinsics_;
  double dt_ = 0;
  Quat dq_ = Quat::Identity();
  Vec3 dp_ = Vec3::Zero(), dv_ = Vec3::Zero();
  Mat9x6 jac_ = Mat9x6::Zero();
  Mat9 jac_intrinsics_ = Mat9::Zero();
  Mat15 cov_ = Mat15::Zero();
  std::vector<Step> steps_;
};

}  // namespace vir::imu
