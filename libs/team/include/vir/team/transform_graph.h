#pragma once
/// Several robots: which worlds can be tied together, and do the transforms agree around loops?
#include <map>
#include <string>
#include <vector>

#include "vir/team/world_transform.h"

namespace vir::team {

/// p_to = T p_from between two robots' worlds.
struct TransformEdge {
  std::string from, to;
  WorldTransform T_to_from;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< (yaw, x, y, z)
};

struct TransformLoop {
  std::string robots;                               ///< "A B C"
  Eigen::Vector4d error = Eigen::Vector4d::Zero();  ///< yaw, x, y, z of going round [rad, m]
  double chi2 = 0;                                  ///< of four degrees of freedom
  bool consistent = true;
};

/// Every loop of three robots. Inconsistent: chi2 above 23.5 (false alarms 1e-4).
std::vector<TransformLoop> checkLoops(const std::vector<TransformEdge>& edges);

/// Covariance of the product T_A_B T_B_C, the two independent.
Eigen::Matrix4d composedCovariance(const WorldTransform& T_A_B, const Eigen::Matrix4d& cov_A_B,
                                   const WorldTransform& T_B_C, const Eigen::Matrix4d& cov_B_C);

/// T_root_X for every robot that edges tie to the root, by the most certain way (least variance
/// of the offset). Edges of inconsistent loops are to be left out by the caller if it wants to.
std::map<std::string, WorldTransform> commonFrame(const std::string& root,
                                                  const std::vector<TransformEdge>& edges);

}  // namespace vir::team
