#pragma once
/// What the loader and the library vir_sensor_roles need to know of the registries beyond their
/// public face.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "vir/roles/plugin_loader.h"
#include "vir/roles/sensor.h"

namespace vir::roles::registry {

/// Registrations from now on are credited to this file (empty: linked in).
void setCurrentPlugin(const std::string& file);
/// Clashes since the last call.
std::vector<std::string> takeProblems();
/// Number of names registered so far.
std::size_t size();

/// Called by vir_sensor_roles when it is loaded: what makes a sensor of a class that MRPT knows,
/// null of others.
using SensorMaker = std::unique_ptr<Sensor> (*)(const std::string& class_name);
void setSensorMaker(SensorMaker maker);

/// False, with the clash kept, if alias or class are registered already or `taken_in_mrpt` says so.
bool addSensor(const SensorEntry& entry, const std::function<bool()>& taken_in_mrpt);
/// Class of the sensor called `name`. Throws PluginError that lists what is available.
std::string sensorClass(const std::string& name);
PluginError unknownToMrpt(const std::string& class_name);

}  // namespace vir::roles::registry
