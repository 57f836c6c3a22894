#pragma once
/// What a run amounts to, for the terminal.
#include <string>

#include "vir/results/run_recorder.h"

namespace vir::app {

void printRunTable(const results::RunSummary& summary, const std::string& folder);

}  // namespace vir::app
