#pragma once
/// A plan as a job array of Slurm: each task is `vir-slam batch --shard I/N` on some node.
#include <string>
#include <vector>

#include "batch/batch_run.h"

namespace vir::app {

struct SlurmJob {
  std::string ini;               ///< absolute: nodes read it
  std::vector<std::string> set;  ///< assignments of the command line
  std::string options;           ///< further words for sbatch
  int tasks = 0;                 ///< of the array; 0: one per recording
};

/// Submits what is not done, waits for it and says how far it is, and submits again, twice at most,
/// what tasks have not done (a node that failed, a time limit). The results folder must be on a
/// file system that all nodes see. An interruption takes the job back. Throws std::runtime_error
/// when Slurm is not there or refuses the job, with its words.
BatchCounts runOnSlurm(const BatchPlan& plan, const BatchRunOptions& options, const SlurmJob& job);

}  // namespace vir::app
