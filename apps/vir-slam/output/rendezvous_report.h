#pragma once
/// What a meeting of robots amounts to: all its files, and the table on the terminal.
#include <string>
#include <vector>

#include "output/console.h"
#include "vir/results/results_folder.h"
#include "vir/team/meeting.h"

namespace vir::app {

/// How it came about.
struct MeetingOrigin {
  std::string command;
  std::vector<std::string> warnings, errors;  ///< of the log
};

/// Writes everything but used.ini and run.log; returns the rows to be shown.
std::vector<TableRow> writeMeeting(const results::ResultsFolder& folder,
                                   const team::Meeting& meeting, const MeetingOrigin& origin);

}  // namespace vir::app
