#include "vir/ranging/range_check.h"

#include <cmath>

namespace vir::ranging {

long RangeCheckCounters::rejected() const {
  long sum = 0;
  for (const auto& item : problems) sum += item.second;
  return sum;
}

std::string RangeCheckCounters::text() const {
  std::string out;
  for (const auto& [problem, count] : problems) {
    if (!out.empty()) out += ", ";
    out += std::to_string(count) + " " + name(problem);
  }
  return out;
}

RangeDecision RangeCheck::check(int anchor, TimeNs t, double range_m) {
  auto it = anchors_.find(anchor);
  if (it == anchors_.end()) {
    if (static_cast<int>(anchors_.size()) >= options_.max_anchors) {
      ++counters_.problems[RangeDecision::too_many_anchors];
      return RangeDecision::too_many_anchors;
    }
    it = anchors_.emplace(anchor, State()).first;
  }
  State& state = it->second;
  const RangeDecision problem = decide(&state, t, range_m);
  for (RangeCheckCounters* c : {&counters_, &state.counters}) {
    if (problem == RangeDecision::accepted) {
      ++c->ok;
    } else {
      ++c->problems[problem];
    }
  }
  return problem;
}

RangeDecision RangeCheck::decide(State* state, TimeNs t, double range_m) {
  if (!std::isfinite(range_m)) return RangeDecision::not_finite;
  if (range_m < 0 && !options_.either_sign) return RangeDecision::negative;
  if (range_m == 0 && !options_.either_sign) return RangeDecision::zero;
  if (std::abs(range_m) > options_.max_range_m) return RangeDecision::too_far;
  const RangeDecision time = decideTime(state, t);
  if (time != RangeDecision::accepted) return time;
  state->equal = range_m == state->value ? state->equal + 1 : 1;
  state->value = range_m;
  return state->equal > options_.max_equal ? RangeDecision::stuck : RangeDecision::accepted;
}

RangeDecision RangeCheck::decideTime(State* state, TimeNs t) {
  if (state->seen && t == state->newest) return RangeDecision::repeated;
  if (state->seen && t < state->newest) {
    // Ranges that go on in order, only earlier, mean that the clock was set back.
    state->backward = state->backward > 0 && t <= state->late ? 1 : state->backward + 1;
    state->late = t;
    if (state->backward <= options_.max_backward) return RangeDecision::out_of_order;
    ++counters_.clock_restarts;
    ++state->counters.clock_restarts;
  }
  state->seen = true;
  state->newest = t;
  state->backward = 0;
  return RangeDecision::accepted;
}

RangeCheckCounters RangeCheck::counters(int anchor) const {
  const auto it = anchors_.find(anchor);
  return it == anchors_.end() ? RangeCheckCounters() : it->second.counters;
}

}  // namespace vir::ranging
