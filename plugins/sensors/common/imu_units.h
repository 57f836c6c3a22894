#pragma once
/// Units of an IMU's readings that somebody names, the same words for all drivers of recordings.
#include <string>
#include <vector>

namespace vir {

/// What [m/s^2] one of it is; 0 for `auto`: what the recording says, or m/s^2.
double accelerationUnit(const std::string& name);
/// What [rad/s] one of it is; 0 for `auto`.
double rateUnit(const std::string& name);

/// The words that are known, `auto` first.
std::vector<std::string> accelerationUnits();
std::vector<std::string> rateUnits();

}  // namespace vir
