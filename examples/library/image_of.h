#pragma once
/// An MRPT image, and the camera that comes with it, as the library takes them.
#include <mrpt/obs/CObservationImage.h>

#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/types/calibration.h"
#include "vir/types/image.h"

inline vir::Calibration calibrationOf(const mrpt::obs::CObservationImage& image) {
  vir::Calibration out;
  out.T_B_C = vir::rawlog::fromMrptPose(image.cameraPose);
  out.camera = vir::rawlog::fromMrptCamera(image.cameraParams);
  return out;
}

/// Of a gray image, whose pixels stay where they are.
inline vir::Image imageOf(const mrpt::obs::CObservationImage& image) {
  vir::Image out;
  out.t = vir::rawlog::fromMrptTime(image.timestamp);
  out.width = static_cast<int>(image.image.getWidth());
  out.height = static_cast<int>(image.image.getHeight());
  out.pixels = image.image.ptrLine<std::uint8_t>(0);
  out.stride = image.image.getRowStride();
  return out;
}
