#pragma once
/// Finished runs: what `vir-slam run` left in its folder, instead of estimating again.
#include <string>

#include "vir/team/robot_record.h"

namespace vir::app {

struct RunFolder {
  std::string path;
  std::string rawlog;  ///< as the run named its recording; may be empty or gone
};

/// Throws UsageError that names what is missing if `path` is no results folder with a trajectory.
RunFolder openRunFolder(const std::string& path);

/// Poses with covariances and segments, anchors (as known in the end), keyframes and map points.
/// Throws std::runtime_error naming file and reason for what cannot be read.
void readRunFolder(const RunFolder& folder, team::RobotRecord* record);

/// What a recording holds beside an estimator's input: ranges, odometry poses, ground truth.
void readRecording(const std::string& rawlog, const std::string& peer_label,
                   team::RobotRecord* record);

}  // namespace vir::app
