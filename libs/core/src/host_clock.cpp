#include "vir/core/host_clock.h"

#include <time.h>

#include <cstdlib>
#include <ctime>
#include <optional>

#include "vir/core/parse_number.h"

namespace vir {
inline namespace core {
namespace {

/// Wall clock less monotonic clock when it was pinned. In the environment, since every plugin has
/// this library of its own.
constexpr const char* kPinned = "VIR_SLAM_CLOCK_OFFSET_NS";

TimeNs read(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<TimeNs>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

HostClocks& clocks() {
  static HostClocks used = systemClocks();
  return used;
}

std::optional<TimeNs> pinned() {
  const char* text = std::getenv(kPinned);
  TimeNs offset = 0;
  if (text == nullptr || !parseNumber(text, &offset)) return std::nullopt;
  return offset;
}

}  // namespace

HostClocks systemClocks() {
  return {[] { return read(CLOCK_REALTIME); }, [] { return read(CLOCK_BOOTTIME); },
          [] { return read(CLOCK_MONOTONIC); }};
}

void useHostClocks(const HostClocks& other) { clocks() = other; }

void pinHostClock() {
  const TimeNs offset = clocks().wall() - clocks().monotonic();
  setenv(kPinned, std::to_string(offset).c_str(), 1);
}

TimeNs hostNow() {
  const std::optional<TimeNs> offset = pinned();
  return offset ? clocks().monotonic() + *offset : clocks().wall();
}

TimeNs hostClockStep() {
  const std::optional<TimeNs> offset = pinned();
  return offset ? clocks().wall() - clocks().monotonic() - *offset : 0;
}

TimeNs hostSlept() { return clocks().monotonic() - clocks().awake(); }

std::string localDateTime() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%d-%H%M%S", &local);
  return text;
}

}  // namespace core
}  // namespace vir
