#include "registry.h"

#include <dlfcn.h>

#include <map>
#include <mutex>
#include <utility>

#include "vir/core/text.h"
#include "vir/roles/estimator_registry.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/rendezvous_registry.h"

namespace vir::roles {
namespace {

/// What plugins of one role have registered, by name; names are not case-sensitive.
template <typename Entry, typename Factory>
struct Registry {
  struct Record {
    Entry entry;
    Factory factory;
  };
  const char* role;
  std::map<std::string, Record> records;

  std::vector<Entry> entries() const {
    std::vector<Entry> out;
    for (const auto& [key, record] : records) out.push_back(record.entry);
    return out;
  }
};

struct Registries {
  std::mutex mutex;
  Registry<EstimatorEntry, EstimatorFactory> estimators{"estimator", {}};
  Registry<RendezvousEntry, RendezvousFactory> rendezvous{"rendezvous solver", {}};
  std::map<std::string, SensorEntry> sensors;  // by alias
  registry::SensorMaker make_sensor = nullptr;
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

template <typename Map, typename Text>
std::string listed(const Map& map, Text text) {
  std::string out;
  for (const auto& item : map) out += (out.empty() ? "" : ", ") + text(item);
  return out.empty() ? "none (no plugin loaded)" : out;
}

template <typename Entry, typename Factory>
void add(Registry<Entry, Factory>* registry, const std::string& name, Factory factory,
         const std::string& description) {
  Registries& r = all();
  const std::lock_guard<std::mutex> lock(r.mutex);
  const auto known = registry->records.find(lowerCase(name));
  if (known != registry->records.end()) {
    r.problems.push_back(std::string(registry->role) + " '" + name + "' is registered twice: by " +
                         origin(known->second.entry.plugin_file) + " and by " +
                         origin(r.current_plugin));
    return;
  }
  registry->records[lowerCase(name)] = {{name, description, r.current_plugin}, std::move(factory)};
}

template <typename Entry, typename Factory>
auto create(const Registry<Entry, Factory>& registry, const std::string& name) {
  Factory factory;
  {
    const std::lock_guard<std::mutex> lock(all().mutex);
    const auto found = registry.records.find(lowerCase(name));
    if (found == registry.records.end()) {
      throw PluginError(std::string("unknown ") + registry.role + " '" + name + "'; available: " +
                        listed(registry.records, [](auto& e) { return e.second.entry.name; }));
    }
    factory = found->second.factory;
  }
  return factory();
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
  return all().estimators.records.size() + all().rendezvous.records.size() + all().sensors.size();
}

void setSensorMaker(SensorMaker maker) {
  const std::lock_guard<std::mutex> lock(all().mutex);
  all().make_sensor = maker;
}

bool addSensor(const SensorEntry& entry, const std::function<bool()>& taken_in_mrpt) {
  Registries& r = all();
  const std::lock_guard<std::mutex> lock(r.mutex);
  const std::string key = lowerCase(entry.alias);
  for (const auto& [known_alias, known] : r.sensors) {
    if (known_alias != key && known.class_name != entry.class_name) continue;
    r.problems.push_back("sensor '" + entry.alias + "' (class " + entry.class_name +
                         ") is registered twice: by " + origin(known.plugin_file) + " and by " +
                         origin(r.current_plugin));
    return false;
  }
  if (taken_in_mrpt()) {
    r.problems.push_back("sensor '" + entry.alias + "': MRPT has a class " + entry.class_name +
                         " already");
    return false;
  }
  r.sensors[key] = {key, entry.class_name, entry.description, r.current_plugin};
  return true;
}

std::string sensorClass(const std::string& name) {
  const Registries& r = all();
  const std::lock_guard<std::mutex> lock(all().mutex);
  std::string class_name;
  for (const auto& [alias, entry] : r.sensors) {
    if (alias == lowerCase(name) || entry.class_name == name) class_name = entry.class_name;
  }
  if (!class_name.empty()) return class_name;
  throw PluginError("unknown sensor driver '" + name +
                    "'; available: " + listed(r.sensors, [](auto& s) { return s.first; }));
}

PluginError unknownToMrpt(const std::string& class_name) {
  return PluginError("sensor class " + class_name + " is not registered with MRPT");
}

}  // namespace registry

void registerEstimator(const std::string& name, EstimatorFactory factory,
                       const std::string& description) {
  add(&all().estimators, name, std::move(factory), description);
}

void registerRendezvous(const std::string& name, RendezvousFactory factory,
                        const std::string& description) {
  add(&all().rendezvous, name, std::move(factory), description);
}

std::vector<EstimatorEntry> registeredEstimators() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  return all().estimators.entries();
}

std::vector<RendezvousEntry> registeredRendezvous() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  return all().rendezvous.entries();
}

std::vector<SensorEntry> registeredSensors() {
  const std::lock_guard<std::mutex> lock(all().mutex);
  std::vector<SensorEntry> entries;
  for (const auto& item : all().sensors) entries.push_back(item.second);
  return entries;
}

std::unique_ptr<EstimatorSettings> estimatorSettings(const std::string& name) {
  return create(all().estimators, name);
}

std::unique_ptr<Rendezvous> createRendezvous(const std::string& name) {
  return create(all().rendezvous, name);
}

std::unique_ptr<Sensor> openSensor(const std::string& name) {
  const std::string class_name = registry::sensorClass(name);
  auto sensor = openMrptSensor(class_name);
  if (!sensor) throw registry::unknownToMrpt(class_name);
  return sensor;
}

std::unique_ptr<Sensor> openMrptSensor(const std::string& class_name) {
  const auto maker = [] {
    const std::lock_guard<std::mutex> lock(all().mutex);
    return all().make_sensor;
  };
  // It is there as soon as a plugin with a sensor is loaded. Beside this library otherwise.
  if (maker() == nullptr && dlopen(VIR_SENSOR_ROLES_FILE, RTLD_NOW | RTLD_LOCAL) == nullptr) {
    const char* reason = dlerror();
    throw PluginError(std::string("cannot load MRPT's drivers: ") +
                      (reason != nullptr ? reason : "unknown reason"));
  }
  return maker()(class_name);
}

}  // namespace vir::roles
