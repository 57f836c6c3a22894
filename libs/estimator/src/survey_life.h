#pragma once
/// Internal: what is known of a survey of the anchors.
#include <cstddef>
#include <string>
#include <vector>

#include "vir/ranging/survey_match.h"
#include "vir/window/long_window.h"

namespace vir::estimator {

struct SurveyLife {
  std::vector<SurveyedAnchor> given;
  ranging::SurveyMatch match;     ///< the last one
  long matched_with = 0;          ///< ranges ever heard of its anchors at that time
  bool found = false;             ///< its anchors are tied
  std::vector<std::string> told;  ///< findings that have been logged
};

}  // namespace vir::estimator
