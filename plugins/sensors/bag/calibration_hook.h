#pragma once
/// The one place where a calibration file comes in.
#include <string>
#include <vector>

#include "camera_setup.h"
#include "problem_log.h"

namespace vir::bag {

/// Intrinsics and places of `cameras` (in the order of their labels) from the file. Throws
/// formats::CalibrationError.
CalibrationExtras applyCalibrationFile(const std::string& path, std::vector<CameraSetup>* cameras,
                                       ProblemLog* log);

}  // namespace vir::bag
