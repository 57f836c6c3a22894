#pragma once
/// Trajectories and lists of images as a user names them on the command line.
#include <string>
#include <vector>

#include "vir/evaluation/trajectory.h"

namespace vir::app {

/// Reads a trajectory and says on stderr what could not be used of it. `what` names it in errors.
Trajectory readTrajectoryFile(const std::string& path, const std::string& what,
                              evaluation::ReadReport* report);

/// Stamps of images from a csv whose first column holds them [ns]. None at all is a UsageError.
std::vector<TimeNs> readImageStamps(const std::string& path);
/// Likewise, without the poses where nothing can have been, which is said; `left_out` counts them.
Trajectory readReferenceFile(const std::string& path, evaluation::ReadReport* read, long* left_out);

}  // namespace vir::app
