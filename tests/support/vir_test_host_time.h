#pragma once
/// The host's clock as plugins read it (vir/core/host_clock.h), said by a test. By the environment,
/// which is how a program tells its plugins that its clock is pinned.
#include <cstdlib>
#include <string>

#include "vir/core/host_clock.h"

namespace vir::test {

class HostTime {
 public:
  ~HostTime() { unsetenv("VIR_SLAM_CLOCK_OFFSET_NS"); }
  /// It is `t` [ns since 1970] now, and goes on from there.
  void is(TimeNs t) {
    const TimeNs offset = t - systemClocks().monotonic();
    setenv("VIR_SLAM_CLOCK_OFFSET_NS", std::to_string(offset).c_str(), 1);
  }
};

}  // namespace vir::test
