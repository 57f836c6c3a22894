#pragma once
#include "vir/core/options.h"

namespace vir {
inline namespace types {

/// How the poses of a device (wheels, tracking camera) err: random walks that grow with the
/// distance travelled, the angle turned and time.
struct OdometryNoise {
  double sigma_per_sqrt_m = 0;  ///< of the position [m/sqrt(m)]
  double sigma_per_rad_m = 0;   ///< of the position in a turn [m/rad]
  double sigma_per_sqrt_s = 0;  ///< of the position with time [m/sqrt(s)]
  double yaw_per_sqrt_m = 0;    ///< of the heading [rad/sqrt(m)]
  double yaw_per_sqrt_rad = 0;  ///< of the heading in a turn [rad/sqrt(rad)]
  double yaw_per_sqrt_s = 0;    ///< of the heading with time [rad/sqrt(s)]
  double vertical_share = 0;    ///< vertical position noise as a share of the horizontal

  /// Of a horizontal axis [m^2] after `metres`, `radians` and `seconds`.
  double positionVariance(double metres, double radians, double seconds) const;
  /// [rad^2]
  double yawVariance(double metres, double radians, double seconds) const;
  /// Never quite 0, which would leave no inverse.
  double usableVerticalShare() const;
};

/// In whatever section is open.
void describe(OptionVisitor& v, OdometryNoise& o);

}  // namespace types
}  // namespace vir
