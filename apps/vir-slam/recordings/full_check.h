#pragma once
/// The whole check of a recording, images included: what `check` does, and `run` where the result
/// cannot be trusted.
#include <functional>

#include "recordings/recording_check.h"
#include "recordings/source_reader.h"
#include "setup/given_calibration.h"
#include "vir/core/settings.h"

namespace vir::app {

/// What an estimator of these settings takes for given: densities of the IMU's noise and the
/// camera's time offset; its own defaults where they say nothing. Throws SettingsError.
void assumeAsIn(const Settings& settings, RecordingCheck* check);

/// Reads a recording from front to back. `calibration` goes over what a rawlog says of itself; any
/// other source has it from its driver. `progress` (0..1) may be empty. Throws as readSource().
SourceReport checkAll(const SourceToRead& what, GivenCalibration* calibration,
                      RecordingCheck* check, const std::function<void(double)>& progress);

/// Labels of cameras that a run of these settings leaves alone beside the one it looks through.
std::vector<std::string> unusedCameras(const RecordingCheck& check, const Settings& used);

/// Why a run of this rawlog may have gone wrong: a line for each finding that is more than a note,
/// the worst first; empty where it cannot be read once more. `used` is the run's own ini.
/// `driver` made the rawlog; empty: not known.
std::vector<std::string> causesIn(const std::string& rawlog, const Settings& used,
                                  GivenCalibration calibration, const std::string& driver = {});

/// What a brief check of a rawlog that has just been written found, a line each. What only images
/// can decide (is the accelerometer negated, or the camera's pose wrong?) they are asked for.
std::vector<std::string> doubtsOf(const RecordingCheck& brief, const std::string& rawlog,
                                  const std::string& driver);

}  // namespace vir::app
