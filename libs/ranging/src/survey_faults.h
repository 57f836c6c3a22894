#pragma once
/// Internal: what is likely to be wrong with a survey that its ranges do not fit.
#include <string>
#include <vector>

#include "survey_places.h"

namespace vir::ranging {

/// A survey as it may be meant, and how the ranges fit it.
struct SurveyHypothesis {
  std::vector<SurveyedAnchor> survey;
  std::vector<char> used;  ///< 0: that anchor's entry is wrong
  SurveyData data;         ///< of those used
  double bias_sigma_m = 0;
  bool uncalibrated = false;
  SurveyPlaces places;
  std::vector<SurveyFinding> findings;
  std::string suspicion;  ///< several things explain the ranges: which; the survey is none of them
  std::string undecided;  ///< it may be the survey, or not: what else it may be
};

/// The ranges of each anchor fit it, with biases that boards may have.
bool believable(const SurveyHypothesis& hypothesis);

/// The survey as given where the ranges fit it, else what explains them far better.
SurveyHypothesis likeliest(const SurveyData& data, const std::vector<SurveyedAnchor>& survey,
                           const SurveyMatchOptions& options);

}  // namespace vir::ranging
