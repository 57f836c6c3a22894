#include "vir/live/live_merger.h"

#include <algorithm>

#include "vir/rawlog/mrpt_time.h"

namespace vir::live {

void LiveMerger::push(std::size_t source, const mrpt::obs::CObservation::Ptr& observation,
                      TimeNs arrival) {
  const TimeNs t = rawlog::fromMrptTime(observation->timestamp);
  ended_[source] = false;
  if (!newest_[source] || t >= *newest_[source]) newest_at_[source] = arrival;
  newest_[source] = std::max(t, newest_[source].value_or(t));
  held_.emplace(t, Held{observation, source, arrival});
}

bool LiveMerger::isFarAhead(TimeNs t, const Held& held) const {
  bool any = false;
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    if (i == held.source || !newest_[i]) continue;
    // One that has been silent would have come as far as time has.
    const TimeNs silent = std::max<TimeNs>(0, held.arrival - newest_at_[i]);
    if (t <= *newest_[i] + silent + options_.max_lead) return false;
    any = true;
  }
  return any;
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
  const bool ahead = isFarAhead(t, held);
  held_.erase(first);
  if (ahead) return Item{held.observation, false};
  last_out_ = t;
  return Item{held.observation, true};
}

}  // namespace vir::live
