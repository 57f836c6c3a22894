#include "vir/ranging/range_check.h"

#include <cmath>

namespace vir::ranging {

const char* name(RangeProblem problem) {
  switch (problem) {
    case RangeProblem::none:
      return "ok";
    case RangeProblem::not_finite:
      return "not_finite";
    case RangeProblem::negative:
      return "negative";
    case RangeProblem::zero:
      return "zero";
    case RangeProblem::too_far:
      return "too_far";
    case RangeProblem::repeated:
      return "repeated";
    case RangeProblem::out_of_order:
      return "out_of_order";
    case RangeProblem::stuck:
      return "stuck";
    case RangeProblem::too_many_anchors:
      return "too_many_anchors";
  }
  return "unknown";
}

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

RangeProblem RangeCheck::check(int anchor, TimeNs t, double range_m) {
  auto it = anchors_.find(anchor);
  if (it == anchors_.end()) {
    if (static_cast<int>(anchors_.size()) >= options_.max_anchors) {
      ++counters_.problems[RangeProblem::too_many_anchors];
      return RangeProblem::too_many_anchors;
    }
    it = anchors_.emplace(anchor, State()).first;
  }
  State& state = it->second;
  const RangeProblem problem = judge(&state, t, range_m);
  for (RangeCheckCounters* c : {&counters_, &state.counters}) {
    if (problem == RangeProblem::none) {
      ++c->ok;
    } else {
      ++c->problems[problem];
    }
  }
  return problem;
}

RangeProblem RangeCheck::judge(State* state, TimeNs t, double range_m) {
  if (!std::isfinite(range_m)) return RangeProblem::not_finite;
  if (range_m < 0) return RangeProblem::negative;
  if (range_m == 0) return RangeProblem::zero;
  if (range_m > options_.max_range_m) return RangeProblem::too_far;
  const RangeProblem time = judgeTime(state, t);
  if (time != RangeProblem::none) return time;
  state->equal = range_m == state->value ? state->equal + 1 : 1;
  state->value = range_m;
  return state->equal > options_.max_equal ? RangeProblem::stuck : RangeProblem::none;
}

RangeProblem RangeCheck::judgeTime(State* state, TimeNs t) {
  if (state->seen && t == state->newest) return RangeProblem::repeated;
  if (state->seen && t < state->newest) {
    // Ranges that go on in order, only earlier, mean that the clock was set back.
    state->backward = state->backward > 0 && t <= state->late ? 1 : state->backward + 1;
    state->late = t;
    if (state->backward <= options_.max_backward) return RangeProblem::out_of_order;
    ++counters_.clock_restarts;
    ++state->counters.clock_restarts;
  }
  state->seen = true;
  state->newest = t;
  state->backward = 0;
  return RangeProblem::none;
}

RangeCheckCounters RangeCheck::counters(int anchor) const {
  const auto it = anchors_.find(anchor);
  return it == anchors_.end() ? RangeCheckCounters() : it->second.counters;
}

}  // namespace vir::ranging
