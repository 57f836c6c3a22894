#pragma once
#include <string>

namespace CLI {
class App;
}

namespace vir::app {

/// `--calibration FILE` of a subcommand; given several times, `files` has all of them, one behind
/// the other as formats::calibrationPaths() takes them apart.
void addCalibrationOption(CLI::App& command, std::string& files, const std::string& what);

}  // namespace vir::app
