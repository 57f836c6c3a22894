#pragma once
/// Internal: loops.csv, and trajectory_odom.tum: the path as it is without loops.
#include <optional>
#include <utility>
#include <vector>

#include "vir/results/results_folder.h"
#include "vir/types/loop_record.h"
#include "vir/types/state.h"

namespace vir::results {

class LoopRecorder {
 public:
  explicit LoopRecorder(const ResultsFolder& folder) : folder_(folder) {}
  /// A pose without corrections. The file is there from the first one on; those that are not
  /// finite or come out of order are left out, as in trajectory.tum.
  void add(const StampedPose& pose);
  /// Closes and writes; how many were accepted, and rejected. Nothing if none were looked for.
  std::optional<std::pair<long, long>> finish(const std::optional<std::vector<LoopRecord>>& loops);
  /// As finish() was given them.
  const std::vector<LoopRecord>& records() const { return records_; }

 private:
  const ResultsFolder& folder_;
  std::optional<OutputFile> odometry_;
  TimeNs last_ = 0;
  std::vector<LoopRecord> records_;
};

}  // namespace vir::results
