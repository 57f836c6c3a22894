#pragma once
#include <mrpt/obs/CObservation.h>

#include <cstddef>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "vir/core/time.h"

namespace vir::rawlog {

struct TimeOrdererOptions {
  TimeNs delay = 1'000'000'000;         ///< how much later than it should an observation may come
  TimeNs max_jump = 5'000'000'000;      ///< a larger step forward must be confirmed ...
  std::size_t jump_confirmations = 10;  ///< ... by so many in a row, else it is a bad stamp
};

/// Puts observations in time order with a bounded delay (rawlog-grabber writes each sensor in
/// bursts), and sees to it that what comes out never goes back in time. What it holds back for good
/// is counted by sensor label:
/// - `late_LABEL`: older than what had been handed out already (beyond the delay);
/// - `repeated_LABEL`: an image or IMU reading with the stamp of the one before;
/// - `bad_stamp_LABEL`: far ahead of everything around it, or a few at first far behind.
class TimeOrderer {
 public:
  explicit TimeOrderer(const TimeOrdererOptions& options = {}) : options_(options) {}

  void push(const mrpt::obs::CObservation::Ptr& observation);
  /// No more input: everything still held becomes available.
  void flush();
  /// The oldest observation that nothing can precede any more, or nullptr.
  mrpt::obs::CObservation::Ptr pop();

  /// By name, in alphabetical order; absent = 0.
  const std::map<std::string, long>& counters() const { return counters_; }
  /// Observations that came after a later one of the same label, and were put before it, by label.
  const std::map<std::string, long>& sorted() const { return sorted_; }
  /// Steps forward in time larger than max_jump that were confirmed [ns].
  const std::vector<TimeNs>& gaps() const { return gaps_; }

 private:
  void insert(const mrpt::obs::CObservation::Ptr& observation, TimeNs t);
  void acceptSuspects();
  void dropSuspects();
  void dropBeginning();
  void count(const char* what, const mrpt::obs::CObservation& observation);

  TimeOrdererOptions options_;
  std::multimap<TimeNs, mrpt::obs::CObservation::Ptr> held_;
  std::set<std::pair<std::string, TimeNs>> held_stamps_;  // of images and IMU readings
  std::map<std::string, TimeNs> last_stamps_;             // per label, of what was handed out
  std::deque<mrpt::obs::CObservation::Ptr> suspects_;
  std::size_t suspects_in_a_row_ = 0;  // without one that goes on as before
  std::size_t old_goes_on_ = 0;        // observations that contradict the suspects
  std::map<std::string, long> counters_, sorted_;
  std::map<std::string, TimeNs> newest_of_;  // per label, of what came in
  std::vector<TimeNs> gaps_;
  bool started_ = false, any_out_ = false, flushed_ = false;
  TimeNs newest_ = 0, last_out_ = 0;
};

}  // namespace vir::rawlog
