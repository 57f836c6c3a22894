#pragma once
#include <functional>
#include <string>

#include "vir/core/options.h"

namespace mrpt::config {
class CConfigFileBase;
}

namespace vir::roles {

/// For CGenericSensor::loadConfig_sensorSpecific(): reads what `describe` declares from section
/// [section] of a rawlog-grabber ini, as strictly as our own command line does. The section may
/// have any name (it is an instance); the keys every sensor has (driver, process_rate, ...) are
/// known here. Throws SettingsError (settings.h).
void readGrabberSection(const mrpt::config::CConfigFileBase& config, const std::string& section,
                        const std::function<void(OptionVisitor&)>& describe);

}  // namespace vir::roles
