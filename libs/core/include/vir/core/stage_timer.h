#pragma once
/// CPU time of the stages of an estimator. For reports only: nothing here may affect an estimate.
#include "vir/core/resource_usage.h"

namespace vir {
inline namespace core {

/// CPU time of this thread [ms].
inline double threadCpuMs() { return 1e3 * threadCpuSeconds(); }

/// Adds the CPU time of a scope, in this thread, to a counter.
class StageTimer {
 public:
  explicit StageTimer(double* ms) : ms_(ms), start_(threadCpuMs()) {}
  ~StageTimer() { *ms_ += threadCpuMs() - start_; }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double* ms_;
  double start_;
};

/// CPU time of this thread from stage to stage.
class StageLaps {
 public:
  /// Since the lap before, or since construction [ms].
  double lapMs() {
    const double now = threadCpuMs(), ms = now - start_;
    start_ = now;
    return ms;
  }

 private:
  double start_ = threadCpuMs();
};

}  // namespace core
}  // namespace vir
