#include "memory_bound.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <mutex>
#include <system_error>

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

/// Address space in use [byte]; 0 where the system does not tell. It is asked for most observations
/// of a recording: the file stays open.
std::uint64_t inUse() {
  static int file = -1;
  static pid_t owner = 0;
  const pid_t self = getpid();
  if (owner != self) {  // a child would be told of its parent
    if (file >= 0) close(file);
    file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    owner = self;
  }
  if (file < 0) return 0;
  char text[64];
  const ssize_t size = pread(file, text, sizeof text, 0);
  std::uint64_t pages = 0;
  if (size > 0 && std::from_chars(text, text + size, pages).ec != std::errc()) return 0;
  static const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return pages * page;
}

}  // namespace

MemoryBound::MemoryBound(std::uint64_t bytes) {
  Shared& s = shared();
  const std::lock_guard<std::mutex> lock(s.mutex);
  ++s.living;
  const std::uint64_t used = inUse();
  if (used == 0) return;
  rlim_t bound = static_cast<rlim_t>(used + bytes);
  if (s.living > 1) bound = std::max(bound, limitNow().rlim_cur);
  const rlimit now{std::min(bound, kBefore.rlim_cur), kBefore.rlim_max};
  setrlimit(RLIMIT_AS, &now);
}

MemoryBound::~MemoryBound() {
  Shared& s = shared();
  const std::lock_guard<std::mutex> lock(s.mutex);
  if (--s.living > 0) return;
  setrlimit(RLIMIT_AS, &kBefore);
}

}  // namespace vir::rawlog
