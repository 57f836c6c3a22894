#pragma once

namespace vir {
inline namespace types {

/// What a robot does while its odometry says nothing, which may have stopped counting: variances
/// after a silence, by one standard deviation of 0.5 m/s and 0.5 rad/s.
/// Of a horizontal axis of the position [m^2].
inline double unseenPositionVariance(double silence_s) {
  const double metres = 0.5 * silence_s;
  return metres * metres;
}
/// Of the heading [rad^2].
inline double unseenYawVariance(double silence_s) {
  const double radians = 0.5 * silence_s;
  return radians * radians;
}

}  // namespace types
}  // namespace vir
