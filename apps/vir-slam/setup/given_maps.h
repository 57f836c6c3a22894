#pragma once
#include <string>
#include <vector>

#include "setup/given_calibration.h"
#include "vir/core/settings.h"
#include "vir/mission/mission_map.h"
#include "vir/roles/estimator.h"

namespace CLI {
class App;
}

namespace vir::app {

/// --map and --save-map.
void addMapOptions(CLI::App& command, std::string* map, std::string* save_map);

/// Throws UsageError naming the file where there is none, or one that cannot be used (damaged, of
/// another version, without a place).
mission::MissionMap readMap(const std::string& file);

/// Throws UsageError where there is no folder for a map to be written, or a folder in its place.
void requireMapPlace(const std::string& file);

/// Maps for the estimator: files as given on the command line (may be empty) go before [Loops] map
/// and save_map, whose paths are relative to their ini. Where there are any, loops are looked for.
/// Returns whether the command line names any. Throws UsageError where there is no such map, or no
/// folder for the one to be written, or a folder where that is to be.
bool takeMaps(const std::string& map, const std::string& save_map, Settings* settings);

/// Throws UsageError if the map that the settings name is of another camera than the images of a
/// recording labelled so, with what is given in place of what it says itself, or
/// cannot be read.
void requireMapOfCamera(const std::string& rawlog, const std::string& label, GivenCalibration given,
                        const Settings& settings);

/// Throws UsageError if an estimator with these inputs sees nothing that a map could hold.
void requireImagesForMaps(const std::string& driver,
                          const std::vector<roles::EstimatorInput>& inputs);

}  // namespace vir::app
