#pragma once
/// The calibration of camera and IMU that recordings agree on: they are run, and run again from
/// what was found, until nothing changes any more.
#include <string>
#include <vector>

#include "commands/commands.h"
#include "vir/runs/pooled_calibration.h"

namespace vir::app {

struct CameraCalibrationJob {
  std::vector<std::string> recordings, assignments;
  std::string ini;          ///< empty: defaults
  std::string calibration;  ///< to begin with; empty: the recordings'
  int passes = 8;           ///< at most
  double converged_sigma = 0.25;
};

struct CameraCalibrationResult {
  Calibration given;
  runs::PooledCalibration found;
  int passes = 0;
  double last_change_sigma = 0;  ///< between the last two passes
  bool converged = false;
  bool complete = true;             ///< every recording could be used, to its end
  std::vector<std::string> doubts;  ///< of the last pass, with the recording's name
};

/// Tells on stderr how it goes. Throws UsageError, SettingsError; std::runtime_error where no
/// recording says anything.
CameraCalibrationResult calibrateCamera(const CameraCalibrationJob& job, const Common& common);

/// given, found and sigma of every number, on stdout.
void printCameraCalibration(const CameraCalibrationResult& result);

/// The subcommand `camera` of `calibrate`.
void addCalibrateCamera(CLI::App* calibrate, Common& common);

}  // namespace vir::app
