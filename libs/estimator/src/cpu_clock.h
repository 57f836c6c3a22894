#pragma once
/// Internal: CPU time, for reports only.
#include "vir/core/resource_usage.h"

namespace vir::estimator {

/// CPU time of this thread [ms].
inline double cpuMs() { return 1e3 * threadCpuSeconds(); }

/// Adds the CPU time of a scope to a counter.
class StageTimer {
 public:
  explicit StageTimer(double* ms) : ms_(ms), start_(cpuMs()) {}
  ~StageTimer() { *ms_ += cpuMs() - start_; }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double* ms_;
  double start_;
};

}  // namespace vir::estimator
