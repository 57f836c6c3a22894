#pragma once
/// Role "sensor": subclasses of mrpt::hwdrivers::CGenericSensor, registered with MRPT (so that the
/// stock rawlog-grabber can use them) and here (so that the command line can name and list them).
#include <mrpt/hwdrivers/CGenericSensor.h>

#include <string>
#include <vector>

namespace vir::roles {

struct SensorEntry {
  std::string alias;        ///< name on our command line, lower case, e.g. "euroc"
  std::string class_name;   ///< MRPT class name without namespace, `driver =` in an ini
  std::string description;  ///< one line
  std::string plugin_file;  ///< path of the shared object; empty if linked in
};

/// Called by VIR_REGISTER_SENSOR while a plugin is being loaded. Never throws: a clash of names is
/// kept and reported by the loader.
void registerSensor(const mrpt::hwdrivers::TSensorClassId* id, const std::string& alias,
                    const std::string& description);

/// All sensors registered so far, ordered by alias.
std::vector<SensorEntry> registeredSensors();

/// Creates a sensor by alias or class name (aliases case-insensitive). Throws PluginError
/// (plugin_loader.h) that lists what is available.
mrpt::hwdrivers::CGenericSensor::Ptr createSensor(const std::string& name);

}  // namespace vir::roles

/// In a plugin's register.cpp, inside the class's namespace (`Class` is written without it), once
/// per sensor: VIR_REGISTER_SENSOR(EurocDataset, "euroc", "EuRoC / TUM-VI folder (mav0)")
#define VIR_REGISTER_SENSOR(Class, alias, description)                        \
  namespace {                                                                 \
  const bool vir_sensor_registered_##Class = [] {                             \
    ::vir::roles::registerSensor(SENSOR_CLASS_ID(Class), alias, description); \
    return true;                                                              \
  }();                                                                        \
  }                                                                           \
  static_assert(true, "")
