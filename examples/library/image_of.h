#pragma once
/// An MRPT image, and the camera that comes with it, as the library takes them.
#include <mrpt/obs/CObservationImage.h>

#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/types/calibration.h"
#include "vir/types/image.h"

inline vir::Calibration calibrationOf(const mrpt::obs::CObservationImage& image) {
  const mrpt::img::TCamera& c = image.cameraParams;
  vir::Calibration out;
  out.T_B_C = vir::rawlog::fromMrptPose(image.cameraPose);
  out.camera.width = static_cast<int>(c.ncols);
  out.camera.height = static_cast<int>(c.nrows);
  out.camera.fx = c.fx(), out.camera.fy = c.fy(), out.camera.cx = c.cx(), out.camera.cy = c.cy();
  if (c.distortion == mrpt::img::DistortionModel::plumb_bob) {
    out.camera.distortion = vir::Distortion::radtan;
    out.camera.dist = {c.k1(), c.k2(), c.p1(), c.p2(), c.k3()};
  } else if (c.distortion == mrpt::img::DistortionModel::kannala_brandt) {
    out.camera.distortion = vir::Distortion::equidistant;
    out.camera.dist = {c.k1(), c.k2(), c.k3(), c.k4(), 0};
  }
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
