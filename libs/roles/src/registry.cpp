#include "registry.h"

#include <mrpt/system/string_utils.h>

#include <map>
#include <mutex>
#include <utility>

#include "vir/roles/estimator_registry.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/rendezvous_registry.h"
#include "vir/roles/sensor_registry.h"

namespace vir::roles {
namespace {

using mrpt::system::lowerCase;

struct EstimatorRecord {
  EstimatorEntry entry;
  EstimatorFactory factory;
};

struct RendezvousRecord {
  RendezvousEntry entry;
  RendezvousFactory factory;
};

struct Registries {
  std::mutex mutex;
  std::map<std::string, EstimatorRecord> estimators;
  std::map<std::string, RendezvousRecord> rendezvous;
  std::map<std::string, SensorEntry> sensors;  // by alias
  std::string current_plugin;
  std::vector<std::string> problems;
};

Registries& all() {
  static Registries registries;
  return registries;
}

std::string origin(const std::string& plugin_file) {
  return plugin_file.empty() ? "this program" : plugin_file;
}

/// MRPT replaces a class of the same name without a word.
bool takenInMrpt(const mrpt::hwdrivers::TSensorClassId* id) {
  const auto sensor = mrpt::hwdrivers::CGenericSensor::createSensorPtr(id->className);
  return sensor != nullptr && sensor->GetRuntimeClass() != id;
}

template <typename Map, typename Text>
std::string listed(const Map& map, Text text) {
  std::string out;
  for (const auto& item : map) out += (out.empty() ? "" : ", ") + text(item);
  return out.empty() ? "none (no plugin loaded)" : out;
}

}  // namespace

namespace registry {

void setCurrentPlugin(const std::string& file) {
  const std::lock_guard<std::mutex> lock(all().mutex);
  all().current_plugin = file;
}

std::vector<std::string> takeProblems() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  return std::exchange(all().problems, {});
}

std::size_t size() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  return all().estimators.size() + all().rendezvous.size() + all().sensors.size();
}

}  // namespace registry

void registerEstimator(const std::string& name, EstimatorFactory factory,
                       const std::string& description) {
  Registries& r = all();
  const std::lock_guard<std::mutex> lock(r.mutex);
  const auto known = r.estimators.find(lowerCase(name));
  if (known != r.estimators.end()) {
    r.problems.push_back("estimator '" + name + "' is registered twice: by " +
                         origin(known->second.entry.plugin_file) + " and by " +
                         origin(r.current_plugin));
    return;
  }
  r.estimators[lowerCase(name)] = {{name, description, r.current_plugin}, std::move(factory)};
}

void registerRendezvous(const std::string& name, RendezvousFactory factory,
                        const std::string& description) {
  Registries& r = all();
  const std::lock_guard<std::mutex> lock(r.mutex);
  const auto known = r.rendezvous.find(lowerCase(name));
  if (known != r.rendezvous.end()) {
    r.problems.push_back("rendezvous '" + name + "' is registered twice: by " +
                         origin(known->second.entry.plugin_file) + " and by " +
                         origin(r.current_plugin));
    return;
  }
  r.rendezvous[lowerCase(name)] = {{name, description, r.current_plugin}, std::move(factory)};
}

void registerSensor(const mrpt::hwdrivers::TSensorClassId* id, const std::string& alias,
                    const std::string& description) {
  Registries& r = all();
  const std::lock_guard<std::mutex> lock(r.mutex);
  const std::string class_name = id->className;
  for (const auto& [known_alias, known] : r.sensors) {
    if (known_alias != lowerCase(alias) && known.class_name != class_name) continue;
    r.problems.push_back("sensor '" + alias + "' (class " + class_name +
                         ") is registered twice: by " + origin(known.plugin_file) + " and by " +
                         origin(r.current_plugin));
    return;
  }
  if (takenInMrpt(id)) {
    r.problems.push_back("sensor '" + alias + "': MRPT has a class " + class_name + " already");
    return;
  }
  r.sensors[lowerCase(alias)] = {lowerCase(alias), class_name, description, r.current_plugin};
  mrpt::hwdrivers::CGenericSensor::registerClass(id);
}

std::vector<EstimatorEntry> registeredEstimators() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  std::vector<EstimatorEntry> entries;
  for (const auto& item : all().estimators) entries.push_back(item.second.entry);
  return entries;
}

std::vector<RendezvousEntry> registeredRendezvous() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  std::vector<RendezvousEntry> entries;
  for (const auto& item : all().rendezvous) entries.push_back(item.second.entry);
  return entries;
}

std::vector<SensorEntry> registeredSensors() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  std::vector<SensorEntry> entries;
  for (const auto& item : all().sensors) entries.push_back(item.second);
  return entries;
}

std::unique_ptr<Estimator> createEstimator(const std::string& name) {
  Registries& r = all();
  EstimatorFactory factory;
  {
    const std::lock_guard<std::mutex> lock(r.mutex);
    const auto found = r.estimators.find(lowerCase(name));
    if (found == r.estimators.end()) {
      throw PluginError("unknown estimator '" + name + "'; available: " +
                        listed(r.estimators, [](auto& e) { return e.second.entry.name; }));
    }
    factory = found->second.factory;
  }
  return factory();
}

std::unique_ptr<Rendezvous> createRendezvous(const std::string& name) {
  Registries& r = all();
  RendezvousFactory factory;
  {
    const std::lock_guard<std::mutex> lock(r.mutex);
    const auto found = r.rendezvous.find(lowerCase(name));
    if (found == r.rendezvous.end()) {
      throw PluginError("unknown rendezvous solver '" + name + "'; available: " +
                        listed(r.rendezvous, [](auto& e) { return e.second.entry.name; }));
    }
    factory = found->second.factory;
  }
  return factory();
}

mrpt::hwdrivers::CGenericSensor::Ptr createSensor(const std::string& name) {
  Registries& r = all();
  std::string class_name;
  {
    const std::lock_guard<std::mutex> lock(r.mutex);
    for (const auto& [alias, entry] : r.sensors) {
      if (alias == lowerCase(name) || entry.class_name == name) class_name = entry.class_name;
    }
    if (class_name.empty()) {
      throw PluginError("unknown sensor driver '" + name +
                        "'; available: " + listed(r.sensors, [](auto& s) { return s.first; }));
    }
  }
  auto sensor = mrpt::hwdrivers::CGenericSensor::createSensorPtr(class_name);
  if (!sensor) throw PluginError("sensor class " + class_name + " is not registered with MRPT");
  return sensor;
}

}  // namespace vir::roles
