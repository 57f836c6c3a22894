#pragma once
/// Both recordings at hand: all tied robots solved together.
#include <string>
#include <vector>

#include "vir/team/joint_solution.h"
#include "vir/team/merged_map.h"

namespace vir::team {

/// Starts from `map`; on success replaces its transforms and trajectories, and the first solution
/// of every pair of tied robots. Robots without odometry poses are left as they are. Returns what
/// the user should know, e.g. why there is no joint solution; empty if all is well.
std::string mergeJointly(const std::vector<RobotRecord>& robots, const JointOptions& options,
                         MergedMap* map, std::vector<PairResult>* pairs, JointSolution* solution);

}  // namespace vir::team
