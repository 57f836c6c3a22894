#pragma once
/// The subcommands. Each lives in commands/NAME.cpp: its add function declares options and
/// examples, and sets a callback that does the work and throws on failure.
#include <functional>
#include <stdexcept>
#include <string>

#include "vir/roles/plugin_loader.h"

namespace CLI {
class App;
}

namespace vir::app {

/// Exit codes of the program.
enum ExitCode { kOk = 0, kRunFailed = 1, kUsage = 2, kDoubtful = 3 };

/// Wrong use of the command line beyond what CLI11 finds itself, a missing input file included:
/// exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Options that every subcommand understands.
struct Common {
  std::string plugin_dir;  ///< empty: beside the program
  std::string command;     ///< as it was called
  bool force = false;      ///< write over what is the user's own
  int exit_code = kOk;     ///< a command that finishes without throwing may still report failure
};

/// Loads the plugins of the plugin folder that have one of these roles.
void loadPlugins(const Common& common, const roles::PluginRoles& roles);

/// Throws UsageError with `what` and the name if there is no such file.
void requireFile(const std::string& path, const std::string& what);

void addBatch(CLI::App& app, Common& common);
void addCalibrate(CLI::App& app, Common& common);
void addImport(CLI::App& app, Common& common);
void addCheck(CLI::App& app, Common& common);
void addEvaluate(CLI::App& app, Common& common);
void addExport(CLI::App& app, Common& common);
void addMap(CLI::App& app, Common& common);
void addPlugins(CLI::App& app, Common& common);
void addRecord(CLI::App& app, Common& common);
void addRendezvous(CLI::App& app, Common& common);
void addRun(CLI::App& app, Common& common);
void addSimulate(CLI::App& app, Common& common);
void addView(CLI::App& app, Common& common);

}  // namespace vir::app
