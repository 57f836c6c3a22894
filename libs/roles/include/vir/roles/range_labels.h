#pragma once
/// Estimators that take the ranges of several antennas of the robot, each under a label of its own.
#include <string>
#include <vector>

#include "vir/roles/estimator.h"

namespace vir::roles {

/// Is `label` one of those in `labels`, which have blanks between them?
bool isAmong(const std::string& label, const std::string& labels);
/// Ranges under each of the labels in `labels`; used where there are any.
void addRangeInputs(const std::string& labels, std::vector<EstimatorInput>* inputs);

}  // namespace vir::roles
