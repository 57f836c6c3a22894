#pragma once
#include <mrpt/obs/CObservation.h>

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "vir/core/time.h"

namespace vir::live {

struct LiveMergerOptions {
  TimeNs delay = 250'000'000;  ///< nothing is held longer, once it is its turn
  /// What is further ahead of where all other sensors must be by now does not go into the main
  /// stream.
  TimeNs max_lead = 1'000'000'000;
};

/// Puts the observations of several live sensors in time order. What comes out as `in_order` never
/// goes back in time; what cannot be fitted in comes out too, marked: nothing is lost.
class LiveMerger {
 public:
  LiveMerger(std::size_t sources, const LiveMergerOptions& options)
      : options_(options), newest_(sources), newest_at_(sources, 0), ended_(sources, false) {}

  struct Item {
    mrpt::obs::CObservation::Ptr observation;
    bool in_order = true;  ///< false: older than what came out, or far ahead of everything else
  };

  /// `arrival` is on the host's clock, as pop()'s `now`; stamps may be on another one.
  void push(std::size_t source, const mrpt::obs::CObservation::Ptr& observation, TimeNs arrival);
  /// The source has ended or failed: nobody waits for it.
  void setEnded(std::size_t source) {
    newest_[source].reset();
    ended_[source] = true;
  }
  /// The next one that nothing can precede any more, or that has waited long enough.
  std::optional<Item> pop(TimeNs now);
  /// No more input: everything held becomes available.
  void flush() { flushed_ = true; }
  std::size_t held() const { return held_.size(); }

 private:
  struct Held {
    mrpt::obs::CObservation::Ptr observation;
    std::size_t source = 0;
    TimeNs arrival = 0;
  };
  bool isFarAhead(TimeNs t, const Held& held) const;
  bool everybodyIsPast(TimeNs t) const;

  LiveMergerOptions options_;
  std::vector<std::optional<TimeNs>> newest_;  // stamp, by source; empty: none yet, or ended
  std::vector<TimeNs> newest_at_;              // its arrival
  std::vector<bool> ended_;
  std::multimap<TimeNs, Held> held_;
  std::optional<TimeNs> last_out_;
  bool flushed_ = false;
};

}  // namespace vir::live
