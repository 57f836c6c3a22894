#pragma once
/// Calibration as it stands in the `sensor.yaml` files of a recording.
#include <array>
#include <optional>
#include <string>

#include "problem_log.h"
#include "vir/geometry/pose.h"

namespace vir::euroc {

enum class Lens { none, radtan, equidistant };

struct CameraYaml {
  int width = 0, height = 0;              ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]
  Lens lens = Lens::none;
  std::array<double, 5> dist{};  ///< radtan: k1 k2 p1 p2 k3; equidistant: k1 k2 k3 k4
  Pose T_B_C;                    ///< camera to the recording's body frame
};

/// Continuous-time noise of the IMU, SI units; zero where the file does not say.
struct ImuYaml {
  double gyro_noise_density = 0;  ///< [rad/s/sqrt(Hz)]
  double gyro_random_walk = 0;    ///< [rad/s^2/sqrt(Hz)]
  double acc_noise_density = 0;   ///< [m/s^2/sqrt(Hz)]
  double acc_random_walk = 0;     ///< [m/s^3/sqrt(Hz)]
  bool has_noise = false;         ///< all four are given and positive
  Pose T_B_I;                     ///< IMU to the recording's body frame, identity in most
};

struct UwbYaml {
  Pose T_B_U;                     ///< antenna in the recording's body frame
  std::optional<double> sigma_m;  ///< range_noise_sigma
};

/// Each throws InputError naming file, key and value for a missing or nonsensical calibration.
CameraYaml readCameraYaml(const std::string& path);
ImuYaml readImuYaml(const std::string& path, ProblemLog* log);
UwbYaml readUwbYaml(const std::string& path);
/// T_BS of any sensor.yaml; identity when the file has none.
Pose readSensorPose(const std::string& path);

}  // namespace vir::euroc
