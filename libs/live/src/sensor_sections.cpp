/// Which sections of an ini are sensors, and the names of their states.
#include <string>
#include <vector>

#include "vir/core/parse_number.h"
#include "vir/core/text.h"
#include "vir/live/acquisition.h"

namespace vir::live {
namespace {

/// Sections whose `driver` is no sensor.
bool isOurs(const std::string& section) {
  const std::string name = lowerCase(section);
  return name == "estimator" || name == "rendezvous";
}

}  // namespace

const char* name(SensorState state) {
  static const char* const kNames[] = {"starting", "running", "waiting", "ended", "missing"};
  return kNames[static_cast<std::size_t>(state)];
}

std::vector<std::string> sensorSections(const Settings& settings) {
  std::vector<std::string> names;
  for (const std::string& section : settings.sections()) {
    const Setting* ignored = settings.find(section, "rawlog-grabber-ignore");
    if (settings.find(section, "driver") == nullptr || isOurs(section)) continue;
    bool ignore = false;
    if (ignored != nullptr && parseBool(ignored->value, &ignore) && ignore) continue;
    names.push_back(section);
  }
  return names;
}

}  // namespace vir::live
