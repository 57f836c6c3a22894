#pragma once
/// What `vir-slam calibrate uwb` shows.
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "output/console.h"
#include "recordings/uwb_recording.h"
#include "vir/evaluation/figure.h"

namespace vir::app {

std::vector<TableRow> calibrationTable(const UwbSamples& data,
                                       const ranging::RangeCalibration& fit);
nlohmann::json calibrationJson(const UwbSamples& data, const ranging::RangeCalibration& fit);
/// Data, mean, 2 sigma of the mean and of a range.
evaluation::Figure calibrationFigure(const UwbSamples& data, const ranging::RangeCalibration& fit);

}  // namespace vir::app
