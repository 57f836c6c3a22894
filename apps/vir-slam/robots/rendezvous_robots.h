#pragma once
/// The robots of a rendezvous: their recordings, settings and runs.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.h"
#include "robots/rendezvous_options.h"
#include "setup/given_calibration.h"
#include "setup/run_options.h"
#include "vir/core/settings.h"
#include "vir/results/results_folder.h"
#include "vir/roles/rendezvous.h"
#include "vir/team/joint_solution.h"
#include "vir/team/robot_record.h"

namespace vir::app {

struct RobotFile {
  std::string name;
  int id = 0;
  std::string rawlog;
  std::string finished;   ///< results folder of its run; empty: it is estimated here
  std::string map;        ///< that a finished run has left; empty: none
  std::string driver;     ///< estimator; empty if finished
  Settings settings;      ///< the ini, and what `import` left beside the recording
  std::string companion;  ///< the latter's name; may be empty
};

/// Everything a rendezvous needs, read and checked before any file is written.
struct Prepared {
  RunOptions run;
  RendezvousRunOptions rendezvous;
  team::JointOptions joint;
  Settings settings;
  GivenCalibration calibration;  ///< of every robot that is estimated here
  std::vector<RobotFile> robots;
  std::string used_ini;

  std::unique_ptr<roles::Rendezvous> createSolver(const LogSink& log) const;
};

/// As given on the command line.
struct RobotArguments {
  std::string ini;
  std::vector<std::string> rawlogs;  ///< NAME=FILE, NAME=FOLDER of a finished run; NAME:ID=...
  std::vector<std::string> ranges;   ///< NAME=FILE: the recording of a finished run
  std::vector<std::string> maps;     ///< NAME=FILE: the map of a finished run
  std::vector<std::string> assignments;
};

/// Loads the plugins. Throws UsageError and SettingsError.
Prepared prepareRobots(const RobotArguments& arguments, const Common& common);

/// Estimates robot `i` into the subfolder of its name, or reads what its finished run left.
team::RobotRecord runRobot(const Prepared& prepared, std::size_t i,
                           const results::ResultsFolder& folder, const LogSink& log,
                           const std::function<void(double)>& progress);

}  // namespace vir::app
