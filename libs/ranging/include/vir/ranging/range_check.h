#pragma once
/// Input validation of ranges, before anything is estimated from them.
#include <map>
#include <string>

#include "vir/core/time.h"
#include "vir/types/range.h"

namespace vir::ranging {

struct RangeCheckOptions {
  double max_range_m = 500;  ///< longer ones are absurd
  int max_equal = 50;        ///< so often exactly the same value in a row: the device is stuck
  int max_backward = 20;     ///< so many late ones in a row: the clock was set back, start anew
  bool either_sign = false;  ///< differences of ranges: zero and below are as good as above
  int max_anchors = 256;     ///< a broken stream of random ids must not fill the memory
};

struct RangeCheckCounters {
  long ok = 0;
  std::map<RangeDecision, long> problems;  ///< never holds `accepted`
  long clock_restarts = 0;                 ///< the clock was taken as set back
  long rejected() const;
  /// "3 negative, 1 repeated"; empty if there was nothing.
  std::string text() const;
};

class RangeCheck {
 public:
  explicit RangeCheck(const RangeCheckOptions& options = {}) : options_(options) {}

  /// Judges a range of `anchor` and counts it: `accepted`, or what is wrong with it. Costs one map
  /// look-up.
  RangeDecision check(int anchor, TimeNs t, double range_m);
  const RangeCheckCounters& counters() const { return counters_; }
  /// Of one anchor; zeros for one never seen.
  RangeCheckCounters counters(int anchor) const;

 private:
  struct State {
    bool seen = false;
    TimeNs newest = 0, late = 0;  // late: of the last one that came late
    int backward = 0;
    double value = 0;
    int equal = 0;
    RangeCheckCounters counters;
  };
  RangeDecision decide(State* state, TimeNs t, double range_m);
  RangeDecision decideTime(State* state, TimeNs t);

  RangeCheckOptions options_;
  std::map<int, State> anchors_;
  RangeCheckCounters counters_;
};

}  // namespace vir::ranging
