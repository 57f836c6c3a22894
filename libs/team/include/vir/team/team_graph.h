#pragma once
/// A whole team in one frame: all transforms between pairs in one least-squares problem, those left
/// out that contradict the others.
#include <map>
#include <string>
#include <vector>

#include "vir/team/transform_graph.h"

namespace vir::team {

/// A robot's world in the common one.
struct PlacedWorld {
  WorldTransform T_root;                                 ///< p_root = T p_own
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of (yaw, x, y, z) [rad, m]
};

struct TeamGraph {
  std::string root;                           ///< whose world is the common one
  std::map<std::string, PlacedWorld> worlds;  ///< of all that are tied to the root, and its own
  std::vector<TransformEdge> used;            ///< between those
  std::vector<TransformEdge> left_out;        ///< contradict the others, or are no transforms
  std::vector<TransformLoop> loops;           ///< of three robots, of all that was given
  double chi2 = 0;                            ///< of `used`
  int redundant = 0;                          ///< degrees of freedom of `chi2`: 4 per loop
};

/// Of two between the same robots the first counts. Where the transforms contradict each other
/// (chi-square beyond what chance does once in 10,000), the one is left out without which the
/// others agree best, until they do; of equals (a single loop does not tell which of its transforms
/// is wrong) the least certain. Edges that are not finite, or whose covariance is none, are left
/// out. In any order of `edges` the same.
TeamGraph solveTeam(const std::string& root, std::vector<TransformEdge> edges);

}  // namespace vir::team
