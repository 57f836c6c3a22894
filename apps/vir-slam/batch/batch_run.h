#pragma once
/// Works through a plan in processes of its own: what is done stays done.
#include <cstddef>
#include <string>
#include <vector>

#include "batch/batch_plan.h"

namespace vir::app {

/// Part `index` (from 1) of `count`; a recording with all of its runs belongs to one part.
struct Shard {
  std::size_t index = 1, count = 1;
};

struct BatchRunOptions {
  std::string out;         ///< results folder
  std::string plugin_dir;  ///< empty: beside the program
  int jobs = 1;            ///< processes at the same time
  Shard shard;
  std::string only;    ///< work whose name `recording/setting` does not hold this is left out
  bool fresh = false;  ///< do again what is done
};

/// Folder of one run below the results folder of a benchmark.
std::string batchRunFolder(const std::string& out, const BatchRecording& recording,
                           const BatchSetting& setting);

/// Names of the runs that belong to this part, `recording/setting`, in order.
std::vector<std::string> batchWork(const BatchPlan& plan, const BatchRunOptions& options);

struct BatchCounts {
  std::size_t done = 0, found_done = 0, failed = 0;
  bool interrupted = false;
};

/// Simulates the recordings that are missing and runs every setting on them; a line on stdout per
/// finished one, a progress bar on a terminal. A run counts as done if its folder says that it
/// ended well with the same arguments, settings and program. Throws std::runtime_error: the folder
/// cannot be written or another process works on the same part of it.
BatchCounts runBatch(const BatchPlan& plan, const BatchRunOptions& options);

}  // namespace vir::app
