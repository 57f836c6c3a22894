#pragma once
/// Inertial readings along a motion.
#include <vector>

#include "vir/core/options.h"
#include "vir/simulation/motion.h"
#include "vir/types/imu_sample.h"

namespace vir::simulation {

struct ImuSimulationOptions {
  double rate_hz = 200;
  double gyro_noise_density = 1.7e-4;  ///< [rad/s/sqrt(Hz)]
  double acc_noise_density = 2.0e-3;   ///< [m/s^2/sqrt(Hz)]
  double gyro_random_walk = 2.0e-5;    ///< [rad/s^2/sqrt(Hz)]
  double acc_random_walk = 3.0e-3;     ///< [m/s^3/sqrt(Hz)]
  double initial_bias_gyro = 0.02;     ///< standard deviation per axis [rad/s]
  double initial_bias_acc = 0.1;       ///< [m/s^2]
  double scale_error = 0;              ///< standard deviation per axis of the gain's error
  double misalignment_rad = 0;         ///< standard deviation of the angle between gyro and body
  double saturation_gyro_radps = 35;   ///< readings are clipped here
  double saturation_acc_mps2 = 160;
  double dropped_share = 0;  ///< readings lost
  double gravity_mps2 = 9.81;
  int seed = 1;
};
/// Section [SimulatedImu].
void describe(OptionVisitor& v, ImuSimulationOptions& o);

struct SimulatedImu {
  std::vector<ImuSample> samples;
  /// True biases, one per sample.
  std::vector<Vec3> bias_gyro, bias_acc;
};

/// Readings from the motion's begin to its end: a_B = R_B_W (a_W - g_W) + ba, all noise from the
/// seed.
SimulatedImu simulateImu(const Motion& motion, const ImuSimulationOptions& options);

}  // namespace vir::simulation
