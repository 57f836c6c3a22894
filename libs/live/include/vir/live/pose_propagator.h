#pragma once
#include <deque>
#include <mutex>
#include <optional>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"
#include "vir/imu/imu_sample.h"

namespace vir::live {

/// A pose between and ahead of the estimates.
struct PropagatedPose {
  TimeNs t = 0;
  Pose T_W_B;
  Vec3 v_W_B = Vec3::Zero();  ///< [m/s]
};

/// Carries the newest estimate on with the readings of the IMU, so that there is a pose per reading
/// with no delay but the IMU's. Any thread.
class PosePropagator {
 public:
  /// An estimate, of a time that readings have passed already as a rule.
  void setState(TimeNs t, const Pose& T_W_B, const Vec3& v_W_B, const Vec3& bias_gyro,
                const Vec3& bias_acc);
  /// There is no estimate to go on from (lost, or not started).
  void clear();
  /// A reading, in time order; the pose at its time, if there is an estimate not older than
  /// `kLongest`.
  std::optional<PropagatedPose> add(const imu::ImuSample& sample);

  /// Without an estimate for so long, positions are no longer worth sending.
  static constexpr TimeNs kLongest = 500'000'000;

 private:
  void step(const imu::ImuSample& from, const imu::ImuSample& to);

  std::mutex mutex_;
  bool has_state_ = false;
  TimeNs state_t_ = 0;  // of the estimate
  Vec3 bias_gyro_ = Vec3::Zero(), bias_acc_ = Vec3::Zero();
  PropagatedPose at_;
  std::deque<imu::ImuSample> samples_;
};

}  // namespace vir::live
