#pragma once
/// Calibration of cameras and IMU from the files that people have.
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "vir/imu/preintegration.h"
#include "vir/types/calibration.h"

namespace vir::formats {

/// How far a file says its numbers may be off, as in vir::CalibrationSigma; empty: it does not say.
struct CameraSigma {
  std::optional<double> position_m, rotation_rad;  ///< of T_B_C, worst axis
  std::optional<double> time_offset_s, readout_s;
  std::optional<double> focal, aspect;  ///< relative
  std::optional<double> centre_px;
  std::optional<double> distortion;  ///< of either radial coefficient
};

/// Gains and axes of the IMU as in vir::Calibration, and how sure they are.
struct ImuCorrection {
  Vec3 gyro_gain = Vec3::Zero(), gyro_axes_rad = Vec3::Zero(), acc_gain = Vec3::Zero();
  std::optional<double> gyro_gain_sigma, gyro_axes_sigma_rad, acc_gain_sigma;
};

struct CalibratedCamera {
  std::string label;          ///< as in the file: `cam0`, `Camera1`; `cam0` where it has no name
  CameraCalibration camera;   ///< of width and height 0 where the file names no size
  std::optional<Pose> T_B_C;  ///< camera in the body (= IMU); empty: not in the file
  std::optional<double> time_offset_s;  ///< stamp of an image + this = its time on the IMU's clock
  std::optional<double> readout_s;      ///< rolling shutter: first row to last
  CameraSigma sigma;
  std::string topic;  ///< of ROS, if the file names one
};

/// What a file says, and what it leaves open.
struct CalibrationFile {
  std::string path;
  std::string format;  ///< for people: "Kalibr", "ORB-SLAM3", ...
  std::vector<CalibratedCamera> cameras;
  std::optional<imu::ImuNoise> imu_noise;       ///< the four densities; else empty
  std::optional<ImuCorrection> imu_correction;  ///< of a run's `inertial` block
  std::optional<double> imu_rate_hz;
  std::string imu_topic;  ///< of ROS, if the file names one
  /// What was assumed, and what is missing with how to give it; a sentence each.
  std::vector<std::string> notes;

  /// The camera labelled `label`, or nullptr.
  const CalibratedCamera* camera(const std::string& label) const;
};

/// what() names file, key, value and what would be right.
class CalibrationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Time offsets of the cameras beside the first, as the setting Camera.other_time_offsets_s takes
/// them: one that is not known is that of the first. Empty where none of them is known.
std::vector<double> otherTimeOffsets(const std::vector<std::optional<double>>& of_cameras);

/// What of the file a run takes as settings, `Section.key=value` each with all digits: noise, gains
/// and axes of the IMU; time offsets of the cameras, readout of the first; how sure all of it is.
std::vector<std::string> settingsOf(const CalibrationFile& file);

/// Reads Kalibr (camchain, camchain-imucam, imu.yaml), OpenVINS, VINS-Mono and VINS-Fusion,
/// ORB-SLAM2 and 3, ROS camera_info, OpenCV's calibration samples, a `sensor.yaml` of EuRoC, and
/// the `calibration.yaml` of a run. Keys that are not known are left alone. Files that a file names
/// (VINS, OpenVINS) are read from its folder. Of several paths (calibrationPaths()) each gives what
/// the others lack; two that hold the same part are refused. Throws CalibrationError.
CalibrationFile readCalibrationFile(const std::string& path);

/// Between the paths of files that are used as one.
inline constexpr char kPathSeparator = ':';
/// Takes them apart; relative ones are below `folder` (empty: the working folder). A name that
/// holds a colon itself is known by its file.
std::vector<std::string> calibrationPaths(const std::string& paths, const std::string& folder = "");
/// Adds what another file holds. Throws CalibrationError where both hold the same part.
void takeFrom(const CalibrationFile& other, CalibrationFile* file);

/// Gives a camera whose size the file does not name that of its images [px]. Throws
/// CalibrationError where the principal point says that they are others.
void takeSizeOfImages(int width, int height, CameraCalibration* camera);

}  // namespace vir::formats
