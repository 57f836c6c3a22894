#pragma once
/// What --calibration FILE says, laid over what a recording says of itself.
#include <mrpt/obs/CObservation.h>

#include <optional>
#include <string>
#include <vector>

#include "vir/formats/calibration_file.h"
#include "vir/rawlog/labels.h"

namespace vir::app {

class GivenCalibration {
 public:
  /// Nothing given: nothing is changed.
  GivenCalibration() = default;
  /// Throws UsageError: no such file, or no calibration.
  explicit GivenCalibration(const std::string& path);

  /// The sensor label that the estimator reads its images under: that camera is the file's one of
  /// the name that the recording gives it (`cam1` of EuRoC), else its first. Any other `CAM1` is
  /// the file's `cam1`.
  void setCameraLabel(const std::string& label) { camera_label_ = label; }
  /// Gives an image (or feature tracks) its camera; leaves everything else alone. Throws
  /// std::runtime_error when an image has another size than the file says.
  void apply(mrpt::obs::CObservation* observation);

  /// `Section.key=value` of the IMU's noise and the camera's time offset.
  std::vector<std::string> assignments() const;
  /// What is taken from the file and what it lacks, for the terminal.
  std::vector<std::string> said() const;

 private:
  const formats::CalibratedCamera* cameraFor(const std::string& label,
                                             const std::string& name) const;

  std::optional<formats::CalibrationFile> file_;
  std::string camera_label_ = rawlog::kCameraLabel;
};

}  // namespace vir::app
