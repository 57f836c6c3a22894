#pragma once
/// What a meeting of robots amounts to: all its files, and the table on the terminal.
#include <vector>

#include "console.h"
#include "rendezvous_output.h"

namespace vir::app {

struct Meeting {
  std::vector<RobotRecord> robots;
  std::vector<PairResult> pairs;
  std::vector<TransformLoop> loops;
  MergedMap map;
};

/// Writes everything but used.ini and run.log; returns the rows to be shown.
std::vector<TableRow> writeMeeting(const ResultsFolder& folder, const Meeting& meeting);

}  // namespace vir::app
