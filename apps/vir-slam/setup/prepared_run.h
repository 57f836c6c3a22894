#pragma once
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.h"
#include "live/foxglove_stream.h"
#include "robots/peer_run.h"
#include "setup/given_calibration.h"
#include "setup/run_options.h"
#include "vir/core/log.h"
#include "vir/roles/estimator.h"
#include "vir/runs/offline_run.h"

namespace vir::app {

/// As given to `vir-slam run`. Without an ini every setting has its default.
struct RunArguments {
  std::string ini, rawlog, out, calibration, anchors, map, save_map;
  std::vector<std::string> assignments;
  bool verbose = false, foxglove = false, view = false;
};

/// Everything a run needs, read and checked before any file is written.
struct PreparedRun {
  RunOptions options;
  /// Where the log goes once there is a folder for it.
  std::shared_ptr<LogSink> log = std::make_shared<LogSink>();
  std::unique_ptr<roles::Estimator> estimator;
  std::vector<roles::EstimatorInput> inputs;  ///< of the estimator
  PeerRun peers;
  GivenCalibration calibration;
  FoxgloveOptions foxglove;
  std::string used_ini, note;
};

/// Plugins are loaded here. Throws UsageError, SettingsError, roles::PluginError.
PreparedRun prepareRun(const RunArguments& arguments, const Common& common);

/// Under which label an estimator of these inputs reads its images.
std::string imageLabel(const std::vector<roles::EstimatorInput>& inputs);

/// How it is played: without the true anchors. What there is to say of its labels goes to `log`.
runs::OfflineRunOptions offlineOptions(const RunOptions& run,
                                       const std::vector<roles::EstimatorInput>& inputs,
                                       const LogSink& log);

}  // namespace vir::app
