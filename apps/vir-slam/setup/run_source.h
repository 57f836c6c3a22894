#pragma once
#include <string>
#include <vector>

#include "commands/commands.h"
#include "setup/prepared_run.h"

namespace vir::app {

/// What `run` was told to take beside settings.
struct RunSource {
  std::string what;  ///< INI, FILE.rawlog or a recording in another format
  std::vector<std::string> topics;
};

/// Finds out which of the three it is and fills in `arguments` (ini, rawlog, out; its calibration
/// goes into an import); a recording in another format is imported into the results folder first.
/// Throws UsageError and what an import throws.
void resolveSource(const RunSource& source, Common& common, RunArguments* arguments);

}  // namespace vir::app
