#include "vir/pipeline/live_merger.h"

#include <algorithm>

#include "vir/pipeline/mrpt_time.h"

namespace vir {

void LiveMerger::push(std::size_t source, const mrpt::obs::CObservation::Ptr& observation,
                      TimeNs arrival) {
  const TimeNs t = fromMrptTime(observation->timestamp);
  ended_[source] = false;
  newest_[source] = std::max(t, newest_[source].value_or(t));
  held_.emplace(t, Held{observation, source, arrival});
}

std::optional<TimeNs> LiveMerger::newestOfOthers(std::size_t source) const {
  std::optional<TimeNs> newest;
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    if (i != source && newest_[i]) newest = std::max(*newest_[i], newest.value_or(*newest_[i]));
  }
  return newest;
}

bool LiveMerger::everybodyIsPast(TimeNs t) const {
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    // One that has said nothing yet may begin before `t`.
    if (newest_[i] ? *newest_[i] < t : !ended_[i]) return false;
  }
  return true;
}

std::optional<LiveMerger::Item> LiveMerger::pop(TimeNs now) {
  if (held_.empty()) return std::nullopt;
  const auto first = held_.begin();
  const TimeNs t = first->first;
  const Held held = first->second;
  // Late already: nothing to wait for.
  if (last_out_ && t < *last_out_) {
    held_.erase(first);
    return Item{held.observation, false};
  }
  const bool waited = now - held.arrival >= options_.delay;
  if (!flushed_ && !waited && !everybodyIsPast(t)) return std::nullopt;
  // A stamp far ahead of all other sensors would make everything that follows late.
  const std::optional<TimeNs> others = newestOfOthers(held.source);
  const bool ahead = others && t > *others + options_.max_lead;
  held_.erase(first);
  if (ahead) return Item{held.observation, false};
  last_out_ = t;
  return Item{held.observation, true};
}

}  // namespace vir
