#pragma once
/// `driver = auto`: the estimator that a recording is for.
#include <memory>
#include <string>

#include "vir/core/settings.h"
#include "vir/roles/estimator.h"

namespace vir::app {

constexpr const char* kAutoDriver = "auto";

/// `driver` itself, or for `auto`: of the estimators that say which inputs they need the one that
/// finds all of them in the rawlog (the most demanding one if several do). If none does, the most
/// demanding one, which then says what it misses. Reads no further than it must. Throws
/// std::runtime_error if the rawlog cannot be opened, SettingsError.
std::string driverFor(const std::string& driver, const Settings& settings,
                      const std::string& rawlog);
/// The same before there is anything to look at: by the labels that are named in the sections of
/// the sensors. A sensor may have a label that its section does not name: if no estimator finds all
/// that it needs, the most demanding one.
std::string driverForLive(const std::string& driver, const Settings& settings,
                          const std::vector<std::string>& sensor_sections);

/// With `auto` an ini may hold settings of each estimator that it may stand for: those of the ones
/// that were not chosen are read, and dropped.
void acceptOtherDrivers(const std::string& asked, const std::string& chosen,
                        SettingsReader* reader);

}  // namespace vir::app
