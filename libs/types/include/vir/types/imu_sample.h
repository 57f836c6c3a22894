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

}  // namespace types
}  // namespace vir
