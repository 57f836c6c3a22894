#pragma once
/// Calibration as it stands in the `sensor.yaml` files of a recording.
#include <optional>
#include <string>
#include <vector>

#include "problem_log.h"
#include "vir/geometry/pose.h"
#include "vir/types/calibration.h"

namespace vir::euroc {

struct CameraYaml {
  CameraCalibration camera;
  Pose T_B_C;            ///< camera to the recording's body frame; identity where nobody knows it
  bool has_pose = true;  ///< somebody does
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

/// A calibration from outside the recording; what the file does not say is empty. Body = IMU.
struct GivenCalibration {
  std::optional<CameraCalibration> camera;
  std::optional<Pose> T_B_C;
  std::optional<double> time_offset_s;  ///< stamp of an image + this = IMU's clock
  std::optional<ImuYaml> imu;
  std::vector<std::string> notes;
  /// All that a camera needs.
  bool isWhole() const { return camera && T_B_C; }
};

/// The file's camera `camera`; else, where `or_first`, its first. Empty for no path.
GivenCalibration readGivenCalibration(const std::string& path, const std::string& camera,
                                      bool or_first = true);

/// Each throws InputError naming file, key and value for a missing or nonsensical calibration.
CameraYaml readCameraYaml(const std::string& path);
ImuYaml readImuYaml(const std::string& path, ProblemLog* log);
UwbYaml readUwbYaml(const std::string& path);
/// T_BS of any sensor.yaml; identity when the file has none.
Pose readSensorPose(const std::string& path);

}  // namespace vir::euroc
