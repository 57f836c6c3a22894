#pragma once
/// The processes that a plan consists of, and which of them have been done.
#include <string>
#include <vector>

#include "batch/batch_plan.h"
#include "batch/batch_run.h"
#include "batch/child_process.h"

namespace vir::app {

/// One process: simulate a recording, or run a setting on one.
struct BatchJob {
  std::size_t recording = 0;
  const BatchSetting* setting = nullptr;  ///< null: simulate
  std::string name, marker, log, key;
  std::vector<std::string> arguments;
};

class BatchJobs {
 public:
  /// Both outlive this.
  BatchJobs(const BatchPlan& plan, const BatchRunOptions& options);

  const std::vector<BatchRecording>& recordings() const { return recordings_; }
  /// Does recording `i` belong to this part of the work?
  bool isOurs(std::size_t i, const Shard& shard) const;
  std::string rawlogOf(const BatchRecording& recording) const;
  BatchJob simulation(std::size_t recording) const;
  /// Of every setting that is asked for.
  std::vector<BatchJob> runs(std::size_t recording) const;

  /// True if the marker says that the job with this key ended well.
  static bool isDone(const BatchJob& job);
  static void mark(const BatchJob& job, const ChildExit& exit, double seconds);

 private:
  BatchJob runOf(std::size_t i, const BatchSetting& setting,
                 const std::string& recording_key) const;
  void complete(BatchJob* job, const std::vector<std::string>& arguments) const;

  const BatchPlan& plan_;
  const BatchRunOptions& options_;
  const std::vector<BatchRecording> recordings_;
  const std::string simulator_key_, program_key_;
};

}  // namespace vir::app
