#pragma once
#include <string>

#include "report_data.h"

namespace vir::results {

/// report.html: the summary as tables, pictures inline, and the script of libs/results/page that
/// puts maps and plots in their place. Needs no other file and no network.
std::string reportHtml(const RunSummary& summary, const ReportData& data);

}  // namespace vir::results
