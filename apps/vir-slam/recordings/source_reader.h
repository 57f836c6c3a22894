#pragma once
/// The observations of a rawlog, or of any recording that `import` reads, without writing a file.
#include <mrpt/obs/CObservation.h>

#include <functional>
#include <string>
#include <vector>

namespace vir::app {

/// By its name.
bool isRawlog(const std::string& source);

struct SourceToRead {
  std::string source;            ///< rawlog, folder or file
  std::vector<std::string> set;  ///< Section.key=value of the source's driver
  std::string calibration;       ///< file; empty: none
};

/// Calls `visit` for every observation with the part read (0..1). Returns what the reader has to
/// say. Throws UsageError, SettingsError, std::runtime_error. Plugins must be loaded.
std::vector<std::string> readSource(
    const SourceToRead& what,
    const std::function<void(mrpt::obs::CObservation& observation, double part)>& visit);

}  // namespace vir::app
