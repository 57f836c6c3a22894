#pragma once
/// Internal: what ties keyframes of the graph, as numbers that its factors take.
#include <Eigen/Core>

#include "vir/mission/mission_graph.h"

namespace vir::mission {

/// Variances of the way from the keyframe before, and of where the estimator has the keyframe.
struct StepNoise {
  Eigen::Vector4d way = Eigen::Vector4d::Ones();  ///< of (motion [m], turn [rad])
  Eigen::Vector4d tie = Eigen::Vector4d::Zero();  ///< 0: no tie
};

/// Of the same segment. The error of the estimator's pose is taken as e_k = a e_(k-1) + w: with
/// a = 1 where its covariance grows (odometry: w is the growth), below where ranges hold it. That
/// is an edge of variance w / a and a tie of variance w / (1 - a)^2.
StepNoise followedNoise(const PathNode& before, const PathNode& node, const GraphOptions& o);
/// Of the way, as the odometry states it [m^2, rad^2], within the same bounds.
Eigen::Vector4d odometryNoise(const PathNode& before, const PathNode& node,
                              const Eigen::Vector4d& stated, const GraphOptions& options);
/// After a loss of vision or a restart: what it can have moved.
StepNoise lostNoise(const PathNode& before, const PathNode& node, const GraphOptions& o);

/// (position, yaw) of a covariance as StateEstimate has it.
Eigen::Matrix4d levelCovariance(const Eigen::Matrix<double, 6, 6>& covariance, const Mat3& R_W_B);

/// Symmetric S with S `from` S' = `to`; `from` and `to` of the same units.
Eigen::Matrix4d transportOf(const Eigen::Matrix4d& from, const Eigen::Matrix4d& to);

/// A loop as an edge: motion in the older's W, turn of W from the older to the newer.
struct LevelLoop {
  Vec3 motion_W = Vec3::Zero();
  double turn_rad = 0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  double tilt_rad = 0;  ///< by which it contradicts gravity
};
/// `older`, `newer`: T_W_B as the estimator has them.
LevelLoop levelLoop(const Loop& loop, const Pose& older, const Pose& newer, const GraphOptions& o);

Eigen::Matrix4d sqrtInformation(const Eigen::Matrix4d& covariance);

}  // namespace vir::mission
