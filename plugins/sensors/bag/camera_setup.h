#pragma once
/// What is known of a camera: from CameraInfo and /tf_static, or from a calibration file.
#include <string>
#include <vector>

#include "bag_options.h"
#include "problem_log.h"
#include "survey.h"
#include "vir/types/calibration.h"

namespace vir::bag {

struct CameraSetup {
  std::string topic;
  CameraCalibration intrinsics;
  bool has_intrinsics = false;
  /// Size of the recorded images that `intrinsics` belong to once they are resized; 0: not known.
  int recorded_width = 0, recorded_height = 0;
  Pose T_B_C;  ///< in the IMU's frame
  bool has_place = false;
};

/// Noise of the IMU and how its clock goes with the cameras', where the file says so; as settings
/// for estimators.
struct CalibrationExtras {
  std::string ini;
};

/// Of CameraInfo for an image topic whose images have the size given; false with `why` if it cannot
/// be used.
bool intrinsicsOf(const CameraInfo& info, const std::string& topic, int width, int height,
                  CameraCalibration* out, std::string* why);

/// Fills in what the recording says; then what the file (options.calibration) says, which wins.
/// `imu_frame`: of the IMU's messages. Throws InputError where something is missing and
/// options.need_calibration.
CalibrationExtras setUpCameras(const Survey& survey, const BagOptions& options,
                               const std::string& imu_frame, std::vector<CameraSetup>* cameras,
                               ProblemLog* log);

/// Of cameras with these topics, in the order of their labels: what each lacks to be used beside
/// others (intrinsics, its place on the IMU), as a part of a sentence; empty where it has both.
/// Throws formats::CalibrationError.
std::vector<std::string> lacksOf(const Survey& survey, const BagOptions& options,
                                 const std::string& imu_frame,
                                 const std::vector<std::string>& topics);

}  // namespace vir::bag
