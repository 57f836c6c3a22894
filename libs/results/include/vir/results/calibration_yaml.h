#pragma once
/// calibration.yaml of a results folder, as formats::readCalibrationFile() takes it back.
#include <string>
#include <vector>

#include "vir/types/calibration.h"

namespace vir::results {

/// As Kalibr writes a chain of cameras, each by its own pose on the IMU, with standard deviations
/// beside it. `further_labels`: of the cameras beside the first, whose standard deviations are
/// `further_sigma` where there are any; those that are not
/// called CAM and a number above 0 have no place in such a file and are named in a comment instead.
std::string calibrationYaml(const Calibration& calibration, const CalibrationSigma& sigma,
                            const std::vector<std::string>& further_labels = {},
                            const std::vector<CalibrationSigma>& further_sigma = {});

}  // namespace vir::results
