#pragma once
/// How calibration files name a lens and list its numbers (Kalibr's way, which the readers of
/// calibration_file.h understand).
#include <string>
#include <vector>

#include "vir/types/calibration.h"

namespace vir::formats {

struct ListedLens {
  std::string camera_model;          ///< `pinhole`, `omni`, `ds`
  std::vector<double> before_focal;  ///< what stands before fx in the list of intrinsics
  std::string distortion_model;      ///< `none`, `radtan`, `equidistant`, `rational_polynomial`
  std::vector<double> coefficients;  ///< of the distortion
};

ListedLens listedLens(const CameraCalibration& camera);

}  // namespace vir::formats
