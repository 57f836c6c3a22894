#pragma once
/// Accelerometer and gyro that come as two streams with their own times (RealSense, phones), as one
/// IMU.
#include <deque>
#include <vector>

#include "vir/types/imu_sample.h"

namespace vir {

/// A reading of one of the two.
struct TimedVector {
  TimeNs t = 0;
  Vec3 v = Vec3::Zero();
};

/// Samples have the gyro's times; the accelerometer is interpolated between its neighbours. Memory
/// is bounded: readings that wait too long for the other stream are dropped.
class ImuPairing {
 public:
  static constexpr TimeNs kLongestGap = 100'000'000;  ///< between two accelerometer readings

  void addAccelerometer(const TimedVector& v);
  void addGyro(const TimedVector& v);
  /// Samples that are ready, in order of time.
  std::vector<ImuSample> take();
  /// Gyro readings without an accelerometer on both sides, or with a hole there; and readings that
  /// went back in time.
  long dropped() const { return dropped_; }

 private:
  void pair();

  std::deque<TimedVector> acc_, gyro_;
  std::vector<ImuSample> ready_;
  long dropped_ = 0;
};

}  // namespace vir
