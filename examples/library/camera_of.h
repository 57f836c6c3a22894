#pragma once
/// The camera of an image, as the library takes it.
#include <mrpt/obs/CObservationImage.h>

#include "vir/camera/camera_model.h"
#include "vir/rawlog/mrpt_pose.h"

inline vir::camera::CameraCalibration calibrationOf(const mrpt::obs::CObservationImage& image) {
  const mrpt::img::TCamera& c = image.cameraParams;
  vir::camera::CameraCalibration out;
  out.width = static_cast<int>(c.ncols);
  out.height = static_cast<int>(c.nrows);
  out.fx = c.fx(), out.fy = c.fy(), out.cx = c.cx(), out.cy = c.cy();
  if (c.distortion == mrpt::img::DistortionModel::plumb_bob) {
    out.distortion = vir::camera::Distortion::radtan;
    out.dist = {c.k1(), c.k2(), c.p1(), c.p2(), c.k3()};
  } else if (c.distortion == mrpt::img::DistortionModel::kannala_brandt) {
    out.distortion = vir::camera::Distortion::equidistant;
    out.dist = {c.k1(), c.k2(), c.k3(), c.k4(), 0};
  }
  return out;
}

/// Camera in the body.
inline vir::Pose T_B_COf(const mrpt::obs::CObservationImage& image) {
  return vir::rawlog::fromMrptPose(image.cameraPose);
}
