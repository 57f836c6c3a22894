#pragma once
/// Internal: CPU time, for reports only.
#include <time.h>

namespace vir::estimator {

/// CPU time of this thread [ms].
inline double cpuMs() {
  timespec ts{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &ts);
  return static_cast<double>(ts.tv_sec) * 1e3 + static_cast<double>(ts.tv_nsec) * 1e-6;
}

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
