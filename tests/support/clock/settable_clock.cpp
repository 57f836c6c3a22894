/// A wall clock that a test can set, and a machine that seems to sleep: loaded into a program
/// before the C library (LD_PRELOAD), it holds for all that the program loads. VIR_TEST_CLOCK names
/// a file of two numbers of 64 bits, which the test changes while the program runs
/// (vir_test_clock.h).
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace {

struct Shift {
  volatile std::int64_t set_ns;    // the wall clock was set by
  volatile std::int64_t slept_ns;  // time that the monotonic clock does not know of
};

const Shift* mapped() {
  const char* name = std::getenv("VIR_TEST_CLOCK");
  const int file = name == nullptr ? -1 : open(name, O_RDONLY | O_CLOEXEC);
  if (file < 0) return nullptr;
  void* at = mmap(nullptr, sizeof(Shift), PROT_READ, MAP_SHARED, file, 0);
  close(file);
  return at == MAP_FAILED ? nullptr : static_cast<const Shift*>(at);
}

std::int64_t shiftOf(clockid_t id) {
  static const Shift* const shift = mapped();
  if (shift == nullptr) return 0;
  const bool wall = id == CLOCK_REALTIME || id == CLOCK_REALTIME_COARSE;
  if (!wall && id != CLOCK_BOOTTIME) return 0;
  return shift->slept_ns + (wall ? shift->set_ns : 0);
}

}  // namespace

extern "C" int clock_gettime(clockid_t id, timespec* t) noexcept {
  constexpr std::int64_t second = 1'000'000'000;
  const long result = syscall(SYS_clock_gettime, id, t);
  const std::int64_t shift = result == 0 ? shiftOf(id) : 0;
  if (shift != 0) {
    const std::int64_t ns = t->tv_sec * second + t->tv_nsec + shift;
    t->tv_sec = ns / second;
    t->tv_nsec = ns % second;
  }
  return static_cast<int>(result);
}

extern "C" int gettimeofday(timeval* t, void* /*zone*/) noexcept {
  timespec now{};
  const int result = clock_gettime(CLOCK_REALTIME, &now);
  t->tv_sec = now.tv_sec;
  t->tv_usec = now.tv_nsec / 1000;
  return result;
}

extern "C" time_t time(time_t* t) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (t != nullptr) *t = now.tv_sec;
  return now.tv_sec;
}
