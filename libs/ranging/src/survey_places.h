#pragma once
/// Internal: all places of a survey that its ranges allow.
#include <vector>

#include "survey_fit.h"

namespace vir::ranging {

struct SurveyOptimum {
  SurveyState x;
  double cost = 0;
};

/// What one hypothesis about survey and biases comes to.
struct SurveyPlaces {
  std::vector<SurveyOptimum> optima;  ///< best first; empty: nothing finite
  double raw_cost = 1e12;             ///< of the best one, by the sigmas as claimed
  std::size_t ranges = 0;             ///< that it is of
  double scale = 1, worth = 1;        ///< as RangeFit::setFactors
  bool consistent = false;            ///< the best one explains most ranges of each anchor
  double bias_spread_m = 0;           ///< of the biases about their median, at most
};

/// Drops what cannot be used; sigma with the drift of the path.
SurveyData surveyData(const std::vector<SurveyRange>& ranges, std::size_t anchors,
                      double drift_ratio);
SurveyData without(const SurveyData& data, std::size_t anchor);
/// Which anchors have ranges.
std::vector<char> heardIn(const SurveyData& data, std::size_t anchors);

SurveyPlaces placesOf(const SurveyData& data, const std::vector<SurveyedAnchor>& survey,
                      const SurveyMatchOptions& options);
/// Of the path's end as of the state.
LevelTransform transformOf(const SurveyData& data, const SurveyState& x);

}  // namespace vir::ranging
