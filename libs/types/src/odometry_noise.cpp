#include "vir/types/odometry_noise.h"

#include <algorithm>

namespace vir {
inline namespace types {

double OdometryNoise::positionVariance(double metres, double radians, double seconds) const {
  return sigma_per_sqrt_m * sigma_per_sqrt_m * metres +
         sigma_per_rad_m * sigma_per_rad_m * radians * radians +
         sigma_per_sqrt_s * sigma_per_sqrt_s * seconds;
}

double OdometryNoise::yawVariance(double metres, double radians, double seconds) const {
  return yaw_per_sqrt_m * yaw_per_sqrt_m * metres + yaw_per_sqrt_rad * yaw_per_sqrt_rad * radians +
         yaw_per_sqrt_s * yaw_per_sqrt_s * seconds;
}

double OdometryNoise::usableVerticalShare() const { return std::max(vertical_share, 1e-2); }

void describe(OptionVisitor& v, OdometryNoise& o) {
  v.value("sigma_per_sqrt_m", o.sigma_per_sqrt_m, {1e-5, 10.0},
          "random walk of the position with the distance [m/sqrt(m)]");
  v.value("sigma_per_rad_m", o.sigma_per_rad_m, {0.0, 10.0}, "position noise of a turn [m/rad]");
  v.value("sigma_per_sqrt_s", o.sigma_per_sqrt_s, {0.0, 10.0},
          "random walk of the position with time [m/sqrt(s)]");
  v.value("yaw_per_sqrt_m", o.yaw_per_sqrt_m, {0.0, 10.0},
          "random walk of the heading with the distance [rad/sqrt(m)]");
  v.value("yaw_per_sqrt_rad", o.yaw_per_sqrt_rad, {0.0, 10.0},
          "random walk of the heading with the angle turned [rad/sqrt(rad)]");
  v.value("yaw_per_sqrt_s", o.yaw_per_sqrt_s, {0.0, 10.0},
          "random walk of the heading with time [rad/sqrt(s)]");
  v.value("vertical_share", o.vertical_share, {0.0, 10.0},
          "vertical position noise as a share of the horizontal (0: motion in a plane)");
}

}  // namespace types
}  // namespace vir
