#pragma once
#include <string>

#include "run_figures.h"
#include "vir/results/run_recorder.h"

namespace vir::results {

/// report.html: the summary as tables, the pictures inline. Needs no other file, no script and no
/// network.
std::string reportHtml(const RunSummary& summary, const RunPictures& pictures);

}  // namespace vir::results
