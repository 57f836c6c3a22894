#pragma once
#include <string>

#include "vir/core/time.h"

namespace vir {
inline namespace core {

/// Where the time comes from [ns].
struct HostClocks {
  TimeNs (*wall)();       ///< since 1970; somebody may set it
  TimeNs (*monotonic)();  ///< since whenever; goes on while the machine sleeps
  TimeNs (*awake)();      ///< likewise, but stands while the machine sleeps
};
HostClocks systemClocks();

/// For tests: another source of time, for this library's users in the same file of code.
void useHostClocks(const HostClocks& clocks);

/// From now on hostNow() goes with the monotonic clock from what the wall clock says now: what is
/// recorded keeps its order and its distances when NTP, a first GPS fix or a user sets the clock.
/// Holds for the whole process, plugins included; to be called before their threads start.
void pinHostClock();

/// The host's clock, ns since 1970. Never asked for by an estimator: the same input gives the same
/// result whenever it comes.
TimeNs hostNow();

/// By how much the wall clock was set since pinHostClock(), forward positive [ns]; 0 without it.
TimeNs hostClockStep();

/// For how long the machine has slept by now, in all, to some microseconds [ns].
TimeNs hostSlept();

/// The time of day where we are, for names of files: `20260131-235959`.
std::string localDateTime();

}  // namespace core
}  // namespace vir
