#pragma once
/// Everything that is tied together, in one world.
#include <map>
#include <string>
#include <vector>

#include "vir/team/pairing.h"
#include "vir/team/team_graph.h"

namespace vir::team {

struct MergedMap {
  std::string root;                                   ///< the robot whose world it is
  std::map<std::string, WorldTransform> T_root;       ///< from each tied robot's world
  std::map<std::string, Eigen::Matrix4d> covariance;  ///< of T_root: (yaw, x, y, z) [rad, m]
  std::vector<TransformEdge> left_out;                ///< pairs that contradict the others
  std::vector<TransformLoop> loops;                   ///< of three robots
  std::map<std::string, Trajectory> trajectories;     ///< of the tied robots, in the root's world
};

/// The pairs whose transform is unique.
std::vector<TransformEdge> edgesOf(const std::vector<PairResult>& pairs);

/// What solveTeam() says, without trajectories.
MergedMap mapOf(const TeamGraph& graph);

/// In the world of the robot that most others can be tied to; of equals, the first one given.
MergedMap merge(const std::vector<RobotRecord>& robots, const std::vector<TransformEdge>& edges);

}  // namespace vir::team
