#pragma once
/// Which ranges of one anchor the estimator believes.
#include <deque>

#include "vir/core/time.h"
#include "vir/types/range.h"

namespace vir::ranging {

/// The gate rejects what the predicted covariance makes improbable. That alone would lock a good
/// anchor out for ever once the covariance is too small, so it looks back: when more than half of
/// the ranges of the recent past disagree, it is the covariance that is wrong and the gate widens.
/// Outliers that are too long come in bursts (no line of sight), so for them the past is long; a
/// range that is too short has no such excuse.
struct GateOptions {
  double chi2 = 16;          ///< of one degree of freedom: 4 sigma
  int max_consecutive = 20;  ///< so many ranges, and ...
  double max_reject_s = 3;   ///< ... so long mostly rejected before the anchor is suspicious
  /// The same where all of them are too long: behind an obstacle that is so.
  double max_blocked_s = 25;
  double min_travel_m = 1;    ///< and the antenna moved so far: behind an obstacle nothing changes
                              ///< while standing
  double min_offset_m = 0.3;  ///< an anchor that moved by less is not worth a new start; the gate
                              ///< always opens up to here in the end
  double max_widening = 5;    ///< limit of the widening, as a factor on sigma, ...
  double max_widening_long = 2.5;  ///< ... and where all that disagrees is too long
  double fallback_sigma_m = 1;     ///< used when the variance is no positive number
};

struct GateCounters {
  long accepted = 0, too_long = 0, too_short = 0;
  long invalid = 0;  ///< residual not finite: rejected
  long widened = 0;  ///< accepted only because the gate was widened
};

class RangeGate {
 public:
  explicit RangeGate(const GateOptions& options = {}) : options_(options) {}

  /// Judges a residual measured - predicted [m] against its variance [m^2] (prediction and noise
  /// together): accepted, too_long, too_short or invalid. `travelled_m` is the length of the
  /// antenna's path so far, any start; leave it out where it is not known: then the antenna counts
  /// as moving. Bounded cost and memory.
  RangeDecision check(TimeNs t, double residual_m, double variance_m2,
                      double travelled_m = kMoving);

  /// Nearly everything has been rejected for long, by residuals that follow one another smoothly,
  /// while the antenna moved: the anchor has been moved, its start was wrong, or we are lost.
  bool suspicious() const { return suspicious_; }
  /// Forgets the past (a new start of the anchor); the counters stay.
  void reset();

  const GateCounters& counters() const { return counters_; }

 private:
  static constexpr double kMoving = -1;
  struct Entry {
    TimeNs t;
    double residual, sigma, nis, travelled;
    bool rejected;
  };
  void remember(const Entry& entry);
  double widening(double span_s) const;
  bool mostlyRejected(double span_s, bool by_decision) const;
  bool allTooLong() const;
  void updateSuspicion();

  GateOptions options_;
  std::deque<Entry> entries_;
  GateCounters counters_;
  TimeNs started_ = 0;
  bool suspicious_ = false;
};

}  // namespace vir::ranging
