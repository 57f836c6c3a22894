#pragma once
/// What a meeting of robots amounts to: all its files, and the table on the terminal.
#include <vector>

#include "output/console.h"
#include "vir/results/results_folder.h"
#include "vir/team/meeting.h"

namespace vir::app {

/// Writes everything but used.ini and run.log; returns the rows to be shown.
std::vector<TableRow> writeMeeting(const results::ResultsFolder& folder,
                                   const team::Meeting& meeting);

}  // namespace vir::app
