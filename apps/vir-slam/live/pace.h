#pragma once
/// What was recorded, shown as fast as it happened.
#include <optional>
#include <utility>

#include "vir/core/resource_usage.h"
#include "vir/core/time.h"

namespace vir::app {

class Pace {
 public:
  /// Until `t` of the recording is due at so many times its speed; 0 if it is. The first `t` asked
  /// for is due at once.
  double secondsUntil(TimeNs t, double speed) {
    const double now = wallSeconds();
    if (!from_) from_ = {t, now};
    const double due = from_->second + toSeconds(t - from_->first) / speed;
    return due > now ? due - now : 0;
  }
  /// The next `t` asked for is the first.
  void restart() { from_.reset(); }

 private:
  std::optional<std::pair<TimeNs, double>> from_;
};

}  // namespace vir::app
