#pragma once
/// What --calibration FILE, or `calibration` in [Estimator], says, laid over what a recording says
/// of itself.
#include <mrpt/obs/CObservation.h>

#include <optional>
#include <string>
#include <vector>

#include "vir/core/settings.h"
#include "vir/formats/calibration_file.h"
#include "vir/rawlog/labels.h"

namespace vir::app {

/// Throws UsageError where one of the files (formats::calibrationPaths()) is not there.
void requireCalibration(const std::string& paths);

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

  /// `Section.key=value`: all but the camera itself (formats::settingsOf()).
  std::vector<std::string> assignments() const;
  /// What is taken from the file and what it lacks, for the terminal.
  std::vector<std::string> said() const;

 private:
  const formats::CalibratedCamera* cameraFor(const std::string& label,
                                             const std::string& name) const;

  std::optional<formats::CalibrationFile> file_;
  std::string camera_label_ = rawlog::kCameraLabel;
};

/// Puts the calibration `path` (several: formats::calibrationPaths()) of the command line (empty:
/// none) and `set`, in this order, over the settings. Without a path the file that [Estimator]
/// `calibration` names, relative to the ini, gives what the ini itself does not. The settings then
/// name the file by its absolute path. Throws UsageError, SettingsError.
GivenCalibration takeCalibration(const std::string& path, const std::vector<std::string>& set,
                                 Settings* settings);

}  // namespace vir::app
