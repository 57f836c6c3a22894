#pragma once
/// What all factors of ranges share (paper, "UWB Factor"): the blocks of parameters, the range as
/// it was measured, and its prediction. Each factor has a file of its own.
///
/// A node of the long window is a keyframe of the odometry with a correction: where it is in W and
/// how the odometry's axes O are turned in W there. Roll and pitch stay the odometry's.
///
/// node   [5]  p_W_B [m], yaw of O in W [rad], log of the odometry's scale
/// anchor [4]  p_W_A [m], bias of its ranges [m]
///
/// A vector d_O of the odometry stands for Rz(yaw) exp(-log_scale) d_O in W.
#include "vir/geometry/pose.h"
#include "vir/ranging/robust_range.h"

namespace vir::factors {

/// One range as its factors need it.
struct RangeTerm {
  double range_m = 0;  ///< bias that depends on the distance already taken off
  double sigma_m = 0.1;
  ranging::RobustRange robust;
};

/// Distance, kept away from zero so that its direction is defined: below this [m] the range says
/// nothing about direction, and the Jacobian fades out.
constexpr double kMinDistance = 0.05;

/// Unwhitened range residual: |p_W_U - p_W_A| + bias - range, with the direction from the anchor to
/// the antenna (zero vector at zero distance, unit length beyond kMinDistance).
struct RangePrediction {
  double value_m = 0;
  Vec3 direction = Vec3::Zero();
};
RangePrediction predictRange(const Vec3& p_W_U, const Vec3& p_W_A, double bias_m, double range_m);

}  // namespace vir::factors
