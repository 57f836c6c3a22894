#include "vir/rawlog/time_orderer.h"

#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>
#include <utility>

#include "vir/core/time_bounds.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::rawlog {
namespace {

/// Few observations before a longer one are no recording of their own.
constexpr TimeNs kLongestPause = 3600'000'000'000;

/// Ranges to several anchors rightly share label and stamp; a second image or IMU reading cannot.
bool oneAtATime(const mrpt::obs::CObservation& observation) {
  using Tracks = mrpt::obs::CObservationStereoImagesFeatures;
  return dynamic_cast<const mrpt::obs::CObservationImage*>(&observation) != nullptr ||
         dynamic_cast<const Tracks*>(&observation) != nullptr ||
         dynamic_cast<const mrpt::obs::CObservationIMU*>(&observation) != nullptr;
}

}  // namespace

void TimeOrderer::push(const mrpt::obs::CObservation::Ptr& observation) {
  const TimeNs t = fromMrptTime(observation->timestamp);
  if (started_ && timeBetween(newest_, t) > options_.max_jump) {
    suspects_.push_back(observation);
    if (++suspects_in_a_row_ >= options_.jump_confirmations) acceptSuspects();
    return;
  }
  if (t > newest_) suspects_in_a_row_ = 0;
  // A straggler from before a true gap proves nothing; several do.
  if (!suspects_.empty() && t > newest_ && ++old_goes_on_ >= options_.jump_confirmations) {
    dropSuspects();
  }
  insert(observation, t);
}

void TimeOrderer::insert(const mrpt::obs::CObservation::Ptr& observation, TimeNs t) {
  if (any_out_ && t < last_out_) return count("late_", *observation);
  if (oneAtATime(*observation)) {
    const auto last = last_stamps_.find(observation->sensorLabel);
    const bool handed_out = last != last_stamps_.end() && last->second == t;
    if (handed_out || !held_stamps_.insert({observation->sensorLabel, t}).second) {
      return count("repeated_", *observation);
    }
  }
  newest_ = started_ ? std::max(newest_, t) : t;
  started_ = true;
  TimeNs& newest = newest_of_.emplace(observation->sensorLabel, t).first->second;
  if (t < newest) ++sorted_[observation->sensorLabel];
  newest = std::max(newest, t);
  held_.emplace(t, observation);
}

void TimeOrderer::acceptSuspects() {
  TimeNs first = INT64_MAX;
  for (const auto& suspect : suspects_) first = std::min(first, fromMrptTime(suspect->timestamp));
  const auto suspects = std::exchange(suspects_, {});
  old_goes_on_ = suspects_in_a_row_ = 0;
  const TimeNs gap = timeBetween(newest_, first);
  if (gap > kLongestPause && !any_out_ && held_.size() < options_.jump_confirmations) {
    dropBeginning();
  } else {
    gaps_.push_back(gap);
  }
  for (const auto& suspect : suspects) insert(suspect, fromMrptTime(suspect->timestamp));
}

void TimeOrderer::dropSuspects() {
  for (const auto& suspect : suspects_) count("bad_stamp_", *suspect);
  suspects_.clear();
  old_goes_on_ = suspects_in_a_row_ = 0;
}

/// A clock that was not set yet: it is the few at first whose stamps are wrong.
void TimeOrderer::dropBeginning() {
  for (const auto& [t, observation] : held_) count("bad_stamp_", *observation);
  held_.clear();
  held_stamps_.clear();
  newest_of_.clear();
  sorted_.clear();
  started_ = false;
}

void TimeOrderer::flush() {
  flushed_ = true;
  // At the end nobody is left to confirm them: one alone is a bad stamp, several are a timeline.
  if (suspects_in_a_row_ > 1) acceptSuspects();
  dropSuspects();
}

mrpt::obs::CObservation::Ptr TimeOrderer::pop() {
  if (held_.empty()) return nullptr;
  const auto first = held_.begin();
  const TimeNs t = first->first;
  if (!flushed_ && timeBetween(t, newest_) < options_.delay) return nullptr;
  auto observation = first->second;
  held_.erase(first);
  if (oneAtATime(*observation)) {
    held_stamps_.erase({observation->sensorLabel, t});
    last_stamps_[observation->sensorLabel] = t;
  }
  last_out_ = t;
  any_out_ = true;
  return observation;
}

void TimeOrderer::count(const char* what, const mrpt::obs::CObservation& observation) {
  ++counters_[what + observation.sensorLabel];
}

}  // namespace vir::rawlog
