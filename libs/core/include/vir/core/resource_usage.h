#pragma once
/// What a run costs. For the summary only: nothing here may affect an estimate.
#include <sys/resource.h>

#include <chrono>
#include <ctime>

namespace vir {
inline namespace core {

inline double clockSeconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// CPU time of all threads of this process [s].
inline double cpuSeconds() { return clockSeconds(CLOCK_PROCESS_CPUTIME_ID); }

/// CPU time of this thread [s].
inline double threadCpuSeconds() { return clockSeconds(CLOCK_THREAD_CPUTIME_ID); }

/// For intervals [s]: a clock that nobody sets.
inline double wallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Largest resident set so far [MB = 1e6 byte].
inline double peakRssMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024e-6;
}

}  // namespace core
}  // namespace vir
