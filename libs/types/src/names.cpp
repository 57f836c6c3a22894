#include "vir/types/anchor.h"
#include "vir/types/range.h"
#include "vir/types/state.h"
#include "vir/types/survey.h"

namespace vir {
inline namespace types {

const char* name(Health health) {
  switch (health) {
    case Health::starting:
      return "starting";
    case Health::ok:
      return "ok";
    case Health::standing:
      return "standing";
    case Health::doubtful:
      return "doubtful";
    case Health::lost:
      break;
  }
  return "lost";
}

std::string healthText(const StateEstimate& estimate) {
  const std::string word = name(estimate.health);
  return estimate.reason.empty() ? word : word + ": " + estimate.reason;
}

const char* name(RangeDecision decision) {
  switch (decision) {
    case RangeDecision::accepted:
      return "accepted";
    case RangeDecision::collected:
      return "collected";
    case RangeDecision::too_long:
      return "too_long";
    case RangeDecision::too_short:
      return "too_short";
    case RangeDecision::invalid:
      return "invalid";
    case RangeDecision::not_finite:
      return "not_finite";
    case RangeDecision::negative:
      return "negative";
    case RangeDecision::zero:
      return "zero";
    case RangeDecision::too_far:
      return "too_far";
    case RangeDecision::repeated:
      return "repeated";
    case RangeDecision::out_of_order:
      return "out_of_order";
    case RangeDecision::stuck:
      return "stuck";
    case RangeDecision::too_many_anchors:
      return "too_many_anchors";
    case RangeDecision::bad_id:
      return "bad_id";
    case RangeDecision::too_late:
      return "too_late";
    case RangeDecision::before_the_start:
      break;
  }
  return "before_the_start";
}

const char* name(AnchorState state) {
  switch (state) {
    case AnchorState::collecting:
      return "collecting";
    case AnchorState::mirror_open:
      return "mirror_open";
    case AnchorState::estimated:
      return "estimated";
    case AnchorState::fixed:
      return "fixed";
    case AnchorState::moved:
      break;
  }
  return "moved";
}

const char* name(SurveyStatus status) {
  switch (status) {
    case SurveyStatus::waiting:
      return "waiting";
    case SurveyStatus::open:
      return "open";
    case SurveyStatus::found:
      return "found";
    case SurveyStatus::contradicted:
      break;
  }
  return "contradicted";
}

bool parse(const std::string& word, AnchorState* state) {
  for (const AnchorState s : {AnchorState::collecting, AnchorState::mirror_open,
                              AnchorState::estimated, AnchorState::fixed, AnchorState::moved}) {
    if (word != name(s)) continue;
    *state = s;
    return true;
  }
  return false;
}

}  // namespace types
}  // namespace vir
