#pragma once
/// One live recording from start to end.
#include <memory>
#include <string>

#include "robots/peer_run.h"
#include "setup/given_calibration.h"
#include "setup/record_options.h"
#include "setup/run_options.h"
#include "vir/core/settings.h"
#include "vir/roles/estimator.h"

namespace vir::app {

struct LiveSessionPlan {
  RecordOptions options;
  RunOptions run;
  Settings settings;                                    ///< with the sections of the sensors
  std::unique_ptr<roles::EstimatorSettings> estimator;  ///< read
  std::string estimator_name;
  std::string results;  ///< folder of the estimate; empty: results/<date-time>
  bool verbose = false;
  GivenCalibration calibration;
  PeerRun peers;  ///< their settings are read

  /// Every setting with its value, the estimator's included.
  std::string usedIni() const;
};

/// Runs until it is interrupted, its time is over or all sensors have ended; prints what came of
/// it. False when something was lost. Throws std::runtime_error: a sensor is missing, the recording
/// cannot be created.
bool runLiveSession(LiveSessionPlan* plan);

}  // namespace vir::app
