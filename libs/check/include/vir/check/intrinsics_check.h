#pragma once
/// Whether the numbers of a camera's calibration can be those of any camera.
#include <optional>
#include <string>

#include "vir/check/finding.h"
#include "vir/types/calibration.h"

namespace vir::check {

/// `camera_intrinsics` (unusable) where a focal length [px] is below 0.1 or above 20 times the
/// image's width, or the centre [px] lies outside of it; empty where they may be right. Of a
/// camera whose size is 0, not known, nothing is said.
std::optional<Finding> intrinsicsFinding(const CameraCalibration& camera,
                                         const std::string& camera_label);

/// `camera_pose_far` (unusable) where the camera's pose is `lever_m` [m] from an IMU that is fixed
/// to it, and no camera is: above 3 m.
std::optional<Finding> mountingFinding(double lever_m, const std::string& camera_label);

}  // namespace vir::check
