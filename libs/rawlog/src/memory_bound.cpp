#include "memory_bound.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <mutex>

namespace vir::rawlog {
namespace {

rlimit limitNow() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0) limit = {RLIM_INFINITY, RLIM_INFINITY};
  return limit;
}

/// The limit is the process's. What it was is asked when this is loaded, since every plugin has
/// this library of its own and must not take another's bound for it.
const rlimit kBefore = limitNow();

struct Shared {
  std::mutex mutex;
  int living = 0;
};

Shared& shared() {
  static Shared s;
  return s;
}

/// Address space in use [byte]; 0 where the system does not tell.
std::uint64_t inUse() {
  std::ifstream in("/proc/self/statm");
  std::uint64_t pages = 0;
  in >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

MemoryBound::MemoryBound(std::uint64_t bytes) {
  Shared& s = shared();
  const std::lock_guard<std::mutex> lock(s.mutex);
  rlimit now = limitNow();
  ++s.living;
  const std::uint64_t used = inUse();
  if (used == 0) return;
  rlim_t bound = static_cast<rlim_t>(used + bytes);
  if (s.living > 1) bound = std::max(bound, now.rlim_cur);
  now.rlim_cur = std::min(bound, kBefore.rlim_cur);
  setrlimit(RLIMIT_AS, &now);
}

MemoryBound::~MemoryBound() {
  Shared& s = shared();
  const std::lock_guard<std::mutex> lock(s.mutex);
  if (--s.living > 0) return;
  setrlimit(RLIMIT_AS, &kBefore);
}

}  // namespace vir::rawlog
