#pragma once
/// Everything that is tied together, in one world.
#include <map>
#include <string>
#include <vector>

#include "vir/team/pairing.h"
#include "vir/team/transform_graph.h"

namespace vir::team {

struct MergedMap {
  std::string root;                                ///< the robot whose world it is
  std::map<std::string, WorldTransform> T_root;    ///< from each tied robot's world
  std::map<std::string, Trajectory> trajectories;  ///< of the tied robots, in the root's world
};

/// The pairs whose transform is unique.
std::vector<TransformEdge> edgesOf(const std::vector<PairResult>& pairs);

/// In the world of the robot that most others can be tied to; of equals, the first one given.
MergedMap merge(const std::vector<RobotRecord>& robots, const std::vector<TransformEdge>& edges);

}  // namespace vir::team
