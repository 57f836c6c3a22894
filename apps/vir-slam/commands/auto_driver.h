#pragma once
/// `driver = auto`: the estimator that a recording is for.
#include <memory>
#include <string>

#include "vir/core/settings.h"
#include "vir/roles/estimator.h"

namespace vir::app {

constexpr const char* kAutoDriver = "auto";

/// `driver` itself, or for `auto`: "vir" where the rawlog has images (or feature tracks) and an
/// IMU, else "odometry" where it has odometry poses, else "vir", which then says what it misses.
/// Reads no further than it must. Throws std::runtime_error if the rawlog cannot be opened.
std::string driverFor(const std::string& driver, const std::string& rawlog);

/// With `auto` an ini may hold settings of each estimator that it may stand for: those of the ones
/// that were not chosen are read, and dropped.
void acceptOtherDrivers(const std::string& asked, const std::string& chosen,
                        SettingsReader* reader);

}  // namespace vir::app
