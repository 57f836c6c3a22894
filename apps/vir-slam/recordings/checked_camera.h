#pragma once
/// What RecordingCheck keeps of a camera.
#include <memory>
#include <optional>
#include <string>

#include "recordings/recording_check.h"

namespace vir::app {

struct RecordingCheck::Camera {
  explicit Camera(const std::string& label) : images(label) {}
  check::ImageCheck images;
  CameraCalibration calibration;
  bool calibrated = false;
  std::optional<check::Finding> intrinsics;  ///< what is wrong with them
  Pose T_B_C;
  std::unique_ptr<check::ImageTurning> turning;
  /// Of a camera beside the first: what it says of the gyro is not heard, only of itself.
  std::unique_ptr<check::TurningCheck> own;
  long count = 0;
};

}  // namespace vir::app
