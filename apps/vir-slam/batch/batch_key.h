#pragma once
/// What a result depends on, as a short text: two that are equal need not be computed twice.
#include <string>
#include <vector>

namespace vir::app {

/// Of the program that runs, its library and its plugins, by content. `plugin_dir` empty: beside
/// the program.
std::string programKey(const std::string& plugin_dir);

/// Of what makes simulated recordings: the simulator's plugin. A change of the estimator does not
/// change them; one of how rawlogs are written is to count up a number in this function.
std::string simulatorKey(const std::string& plugin_dir);

/// Of a command: `before` (another key), the content of files, and arguments. A file that cannot be
/// read counts as empty.
std::string keyOf(const std::string& before, const std::vector<std::string>& files,
                  const std::vector<std::string>& arguments);

/// Size of a file and when it was written; empty if it is not there.
std::string sizeText(const std::string& file);

}  // namespace vir::app
