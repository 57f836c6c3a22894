#pragma once
/// Stamps of images that scatter about the times at which they were taken.
#include <optional>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/check/turning_check.h"

namespace vir::check {

/// `pairs`: on one clock. `bias`: of the gyro [rad/s].
std::optional<Finding> stampNoise(const std::vector<TurnPair>& pairs, const Mat3& R_C_B,
                                  const Vec3& bias, const std::string& camera_label);

}  // namespace vir::check
