#pragma once
/// Both recordings at hand: all tied robots solved together.
#include <string>
#include <vector>

#include "output/rendezvous_output.h"
#include "robots/pair_rendezvous.h"
#include "vir/team/joint_solution.h"

namespace vir::app {

/// Starts from `map`; on success replaces its transforms and trajectories, and the first solution
/// of every pair of tied robots. Robots without odometry poses are left as they are. Returns what
/// the user should know, e.g. why there is no joint solution; empty if all is well.
std::string mergeJointly(const std::vector<RobotRecord>& robots, const team::JointOptions& options,
                         MergedMap* map, std::vector<PairResult>* pairs,
                         team::JointSolution* solution);

}  // namespace vir::app
