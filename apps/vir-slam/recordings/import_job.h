#pragma once
/// A recording in another format into a rawlog: what `import` does, and `run` before it runs.
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor.h"

namespace vir::app {

struct ImportJob {
  std::string driver;               ///< empty: found from the source
  std::string source, out;          ///< out: the rawlog
  std::string calibration;          ///< file; empty: none
  std::vector<std::string> topics;  ///< ROLE=NAME each
  std::vector<std::string> set;     ///< Section.key=value each
  int compression = 1;
  bool stereo = false;  ///< CAM0 and CAM1 of one stamp as one CObservationStereoImages
};

struct OpenedSource {
  std::unique_ptr<roles::Sensor> sensor;
  roles::RecordedSource* source = nullptr;
  std::string driver;
};
/// Throws UsageError if there is no such file or folder, or the file is empty.
void requireSource(const std::string& source);
/// Found, and set as its section [driver] in `set`, `topics` and `calibration` say; not yet
/// initialised. Throws as importRecording.
OpenedSource openSource(const ImportJob& job);

/// The one sensor that says that it can read `source`; empty if none does. Plugins must be loaded.
/// Throws UsageError if there are several.
std::string driverThatReads(const std::string& source);

/// False if the source is damaged or was cut off. Throws UsageError, SettingsError,
/// std::runtime_error. Plugins must be loaded.
bool importRecording(const ImportJob& job);
/// A table of what the source has.
std::string listRecording(const ImportJob& job);

}  // namespace vir::app
