#pragma once
/// What a meeting of robots amounts to: all its files, and the table on the terminal.
#include <vector>

#include "output/console.h"
#include "output/rendezvous_output.h"

namespace vir::app {

struct Meeting {
  std::vector<RobotRecord> robots;
  std::vector<PairResult> pairs;
  std::vector<team::TransformLoop> loops;
  MergedMap map;
};

/// Writes everything but used.ini and run.log; returns the rows to be shown.
std::vector<TableRow> writeMeeting(const results::ResultsFolder& folder, const Meeting& meeting);

}  // namespace vir::app
