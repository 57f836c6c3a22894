#pragma once
/// Role "sensor": subclasses of mrpt::hwdrivers::CGenericSensor, registered with MRPT (so that the
/// stock rawlog-grabber can use them) and here (so that the command line can name and list them).
/// For plugins: the library is vir::sensor_roles. The program uses sensor.h.
#include <mrpt/hwdrivers/CGenericSensor.h>

#include <string>

#include "vir/roles/sensor.h"

namespace vir::roles {

/// Called by VIR_REGISTER_SENSOR while a plugin is being loaded. Never throws: a clash of names is
/// kept and reported by the loader.
void registerSensor(const mrpt::hwdrivers::TSensorClassId* id, const std::string& alias,
                    const std::string& description);

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
