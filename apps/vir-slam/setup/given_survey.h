#pragma once
#include <string>

#include "vir/core/settings.h"

namespace vir::app {

/// Surveyed anchors for the estimator: `anchors` (a file, as given on the command line; may be
/// empty) goes before [Ranges] surveyed_anchors, whose path is relative to its ini. The names that
/// the importer of `rawlog` (may be empty) gave numbers to go into [Ranges] anchor_names. Throws
/// UsageError where there is no such file.
void takeSurvey(const std::string& anchors, const std::string& rawlog, Settings* settings);

}  // namespace vir::app
