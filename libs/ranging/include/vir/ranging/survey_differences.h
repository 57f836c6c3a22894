#pragma once
/// How does a survey of anchors lie in the world of a path, where only differences of ranges (TDoA)
/// are heard?
#include <cstddef>
#include <vector>

#include "vir/ranging/survey_match.h"

namespace vir::ranging {

/// The range to one surveyed anchor less that to another, and where the antenna was in W.
struct SurveyDifference {
  std::size_t anchor = 0, reference = 0;  ///< indices in the survey
  Vec3 p_W = Vec3::Zero();
  double difference_m = 0;
  double sigma_m = 0.1;
};

/// As matchSurvey(), from at least three anchors; the survey itself is taken as right, its sigmas
/// as noise of the differences. Of the options `min_ranges`, `drift_ratio`, `max_sigma_m`,
/// `mirror_chi2`, `bias_sigma_m` and `robust` are used. Differences in order of time.
/// Deterministic; finite for any input; `waiting` with a reason where the path does not tell yet.
SurveyMatch matchSurveyByDifferences(const std::vector<SurveyDifference>& differences,
                                     const std::vector<SurveyedAnchor>& survey,
                                     const SurveyMatchOptions& options);

}  // namespace vir::ranging
