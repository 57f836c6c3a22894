#include "setup/given_maps.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "commands/commands.h"
#include "vir/core/text.h"
#include "vir/rawlog/convert.h"

namespace vir::app {
namespace {

namespace fs = std::filesystem;

/// Absolute; empty where none is named.
std::string named(const std::string& given, const std::string& key, const Settings& settings) {
  std::string path = given;
  if (path.empty()) {
    const Setting* setting = settings.find("Loops", key);
    if (setting == nullptr || setting->value.empty()) return {};
    path = setting->value;
    if (setting->origin.line > 0 && fs::path(path).is_relative()) {
      path = (fs::path(setting->origin.file).parent_path() / path).string();
    }
  }
  return fs::absolute(path).lexically_normal().string();
}

}  // namespace

void addMapOptions(CLI::App& command, std::string* map, std::string* save_map) {
  command.add_option("--map", *map, "Map of an earlier run, in whose frame this one is to go on");
  command.add_option("--save-map", *save_map, "Map to write at the end");
}

mission::MissionMap readMap(const std::string& file) {
  requireFile(file, "map");
  try {
    return mission::loadMap(file);
  } catch (const std::runtime_error& e) {
    throw UsageError(e.what());
  }
}

void requireMapPlace(const std::string& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  if (!fs::is_directory(folder)) {
    throw UsageError("there is no folder " + folder.string() + " to write the map " + file + " to");
  }
  if (fs::is_directory(file)) {
    throw UsageError(file + " is a folder: name the file that the map is written to");
  }
}

bool takeMaps(const std::string& map, const std::string& save_map, Settings* settings) {
  const std::string from = named(map, "map", *settings),
                    to = named(save_map, "save_map", *settings);
  if (!from.empty()) {
    requireFile(from, "map");
    settings->set("Loops.map=" + from);
  }
  if (!to.empty()) {
    requireMapPlace(to);
    settings->set("Loops.save_map=" + to);
  }
  const bool any = !map.empty() || !save_map.empty();
  const Setting* loops = settings->find("Estimator", "loops");
  if (any && loops != nullptr && lowerCase(loops->value) == "false") {
    throw UsageError(
        "--map and --save-map need the places that loops are found by: leave out [Estimator] "
        "loops = false");
  }
  if (any) settings->set("Estimator.loops=true");
  return any;
}

void requireMapOfCamera(const std::string& rawlog, const std::string& label, GivenCalibration given,
                        const Settings& settings) {
  const std::string map = named({}, "map", settings);
  if (map.empty()) return;
  Calibration here;
  try {
    here = rawlog::calibrationIn(
        rawlog, label, [&](mrpt::obs::CObservation* observation) { given.apply(observation); });
  } catch (const std::runtime_error&) {
    return;  // the run will say that there are no images
  }
  if (here.camera.width == 0) return;
  const std::string other = mission::cameraDifference(readMap(map).calibration.camera, here.camera);
  if (other.empty()) return;
  throw UsageError("the map " + map + " is of another camera than " + rawlog + ": " + other +
                   ". Take a map that was made with this one, or give its calibration by "
                   "--calibration");
}

void requireImagesForMaps(const std::string& driver,
                          const std::vector<roles::EstimatorInput>& inputs) {
  const bool sees = std::any_of(inputs.begin(), inputs.end(), [](const roles::EstimatorInput& i) {
    return i.kind == roles::InputKind::image;
  });
  if (sees) return;
  throw UsageError("estimator '" + driver +
                   "' uses no images, which maps are made of: leave out --map and --save-map, or "
                   "set [Estimator] driver");
}

}  // namespace vir::app
