#pragma once
/// A run's results in the frame of a survey of the anchors.
#include <string>

#include "vir/results/results_folder.h"
#include "vir/types/state.h"
#include "vir/types/survey.h"

namespace vir::results {

/// Can poses be given in the survey's frame: is its turn known?
bool inSurveyFrame(const SurveyFit& survey);

/// trajectory_survey.tum, trajectory_smoothed_survey.tum and anchors_survey.csv, where they can be.
/// Throws std::runtime_error if that fails.
void writeSurveyFiles(const ResultsFolder& folder, const SurveyFit& survey,
                      const Trajectory& causal, const Trajectory& smoothed);

/// What there is to be told of it, for people; a line each.
std::vector<std::string> surveyWarnings(const SurveyFit& survey);

}  // namespace vir::results
