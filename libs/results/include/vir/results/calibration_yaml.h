#pragma once
/// calibration.yaml of a results folder, as formats::readCalibrationFile() takes it back.
#include <string>

#include "vir/types/calibration.h"

namespace vir::results {

/// As Kalibr writes a chain of one camera, with standard deviations beside it.
std::string calibrationYaml(const Calibration& calibration, const CalibrationSigma& sigma);

}  // namespace vir::results
