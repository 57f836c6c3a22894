#pragma once
/// Whether a command may write where something is already.
#include <string>

#include "commands/commands.h"

namespace vir::app {

/// What is about to be written.
enum class Written { results, rawlog, json, picture, calibration, range_bias, mcap, map, film };

/// Nothing happens where `path` is empty, is not there yet, or is what an earlier call of the same
/// command left there, so that a command can be given again. Everything else is the user's own:
/// throws UsageError that names it and --force, which lets it be written over.
void refuseToOverwrite(const std::string& path, Written what, const Common& common);

}  // namespace vir::app
