#pragma once
/// Poses of a device that does its own odometry (wheels, tracking camera).
#include "vir/core/options.h"
#include "vir/simulation/motion.h"

namespace vir::simulation {

struct OdometrySimulationOptions {
  double rate_hz = 20;
  double scale_error = 0.02;          ///< of all distances, constant
  double scale_wander = 0.01;         ///< standard deviation of a part that wanders
  double scale_wander_s = 10;         ///< its time constant
  double yaw_drift_radps = 0;         ///< constant
  double yaw_walk = 0.002;            ///< random walk of the yaw [rad/sqrt(s)]
  double position_walk = 0.005;       ///< random walk of the position [m/sqrt(s)]
  double position_noise_m = 0.001;    ///< white, on every pose
  double attitude_noise_rad = 0.001;  ///< white, on every pose
  int seed = 1;
};
/// Section [SimulatedOdometry].
void describe(OptionVisitor& v, OdometrySimulationOptions& o);

/// Poses T_O_B; O has z up, and its origin and heading are those of the first pose. Roll and pitch
/// do not drift.
Trajectory simulateOdometry(const Motion& motion, const OdometrySimulationOptions& options);

}  // namespace vir::simulation
