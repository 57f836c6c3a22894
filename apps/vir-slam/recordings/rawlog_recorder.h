#pragma once
/// What `import` and `simulate` have in common: a recorded or simulated sensor to its end into a
/// rawlog.
#include <string>

#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor.h"

namespace vir::app {

struct RecordingJob {
  roles::Sensor* sensor = nullptr;          ///< configured, not initialised
  roles::RecordedSource* source = nullptr;  ///< the same object
  std::string out;                          ///< rawlog to write
  int compression = 1;                      ///< 0 .. 9
  std::string command;                      ///< "import": named in the ini written beside
  std::string driver;                       ///< its alias; empty: not one to import with
  bool stereo = false;                      ///< CAM0 and CAM1 of one stamp in one observation
};

/// Throws UsageError for a name that is not one of a rawlog: the other files that are written
/// beside it would otherwise have the same name.
void requireRawlogName(const std::string& rawlog);

/// Writes `x.rawlog`, its images, `x.ini` and `x_anchors_truth.csv`, and prints what went into
/// them. All appear when they are complete. False if the source is damaged or was cut off: then
/// they hold what could be read. Throws std::runtime_error, also if another process writes them.
bool recordToRawlog(const RecordingJob& job);

}  // namespace vir::app
