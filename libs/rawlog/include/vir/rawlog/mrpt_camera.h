#pragma once
/// MRPT's cameras stop here.
#include <mrpt/img/TCamera.h>

#include <string>

#include "vir/types/calibration.h"

namespace vir::rawlog {

/// MRPT knows no distortion, plumb-bob (with the coefficients of `rational` as well) and
/// Kannala-Brandt. `double_sphere` and `omni` are kept as no distortion with the coefficients in
/// `dist` and a name that ends in " model=double_sphere" or " model=omni".
CameraCalibration fromMrptCamera(const mrpt::img::TCamera& camera);
/// `name` is that of the camera, without a model.
mrpt::img::TCamera toMrptCamera(const CameraCalibration& camera, const std::string& name);
/// The name that toMrptCamera() was given.
std::string nameOf(const mrpt::img::TCamera& camera);

}  // namespace vir::rawlog
