#pragma once
/// The one place where a calibration file comes in.
#include <string>
#include <vector>

#include "camera_setup.h"
#include "problem_log.h"

namespace vir::bag {

/// Topics that a calibration file calls by name.
struct CalibratedTopics {
  std::vector<std::string> cameras;  ///< in its order, those without a name left out
  std::string imu;                   ///< empty: not named
};
/// Of no file (an empty path) none. Throws formats::CalibrationError.
CalibratedTopics calibratedTopics(const std::string& path);

/// Intrinsics and places of `cameras` (in the order of their labels) from the file. Throws
/// formats::CalibrationError.
CalibrationExtras applyCalibrationFile(const std::string& path, std::vector<CameraSetup>* cameras,
                                       ProblemLog* log);

}  // namespace vir::bag
