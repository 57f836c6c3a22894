#pragma once
#include "vir/core/time.h"
#include "vir/geometry/so3.h"

namespace vir {
inline namespace types {

/// One IMU reading in the body frame.
struct ImuSample {
  TimeNs t = 0;
  Vec3 gyro = Vec3::Zero();  ///< angular rate [rad/s]
  Vec3 acc = Vec3::Zero();   ///< specific force [m/s^2]: at rest it points up
};

/// What an IMU would have read at `t`, on the straight line through two readings of different
/// times.
inline ImuSample interpolated(const ImuSample& a, const ImuSample& b, TimeNs t) {
  const double u = static_cast<double>(t - a.t) / static_cast<double>(b.t - a.t);
  return {t, a.gyro + u * (b.gyro - a.gyro), a.acc + u * (b.acc - a.acc)};
}

}  // namespace types
}  // namespace vir
