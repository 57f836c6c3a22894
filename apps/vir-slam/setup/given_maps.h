#pragma once
#include <string>

#include "vir/core/settings.h"

namespace vir::app {

/// Maps for the estimator: files as given on the command line (may be empty) go before [Loops] map
/// and save_map, whose paths are relative to their ini. Where there are any, loops are looked for.
/// Throws UsageError where there is no such map, or no folder for the one to be written.
void takeMaps(const std::string& map, const std::string& save_map, Settings* settings);

}  // namespace vir::app
