#pragma once
/// What has no message of ROS, as JSON: plots, log and annotations in the shape of Foxglove's
/// schemas.
#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir::app {

using Json = nlohmann::ordered_json;

/// A schema that names the fields of `example` and the kind of each.
std::string schemaOf(const std::string& title, const Json& example);
/// State, its standard deviations and what it rests on, for plots.
Json healthJson(const StateEstimate& e);
/// A range, and what became of it.
Json rangeJson(const RangeRecord& r);
/// foxglove.Log.
Json logJson(TimeNs t, LogLevel level, const std::string& line);
/// foxglove.ImageAnnotations: a point per feature.
Json annotationsJson(TimeNs t, const std::vector<Eigen::Vector2f>& pixels);

}  // namespace vir::app
