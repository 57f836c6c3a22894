#pragma once
/// All robots in one least-squares problem, offline: each one's path (odometry that drifts and has
/// a scale of its own), the anchors, and the transforms between the worlds. A mutual range then
/// corrects both paths, which a transform between two finished paths cannot.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/ranging/robust_range.h"
#include "vir/team/world_transform.h"
#include "vir/types/odometry_noise.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir::team {

struct JointRobot {
  std::vector<StampedPose> odometry;  ///< T_O_B, z up, in order of time
  std::vector<StampedPose> estimate;  ///< T_W_B as estimated alone: where to start, and its world
  std::vector<Range> anchor_ranges;
  WorldTransform T_C_W;  ///< from its world to the common one, as found from the mutual ranges
};

struct JointMutualRange {
  TimeNs t = 0;
  std::size_t first = 0, second = 0;  ///< places in the list of robots
  double range_m = 0, sigma_m = 0.1;
  Vec3 p_first_U = Vec3::Zero(), p_second_U = Vec3::Zero();  ///< antennas
};

/// Of wheels on a floor: hardly any noise upwards.
OdometryNoise jointNoiseDefaults();

struct JointOptions {
  double node_distance_m = 0.15, node_turn_rad = 0.3, node_interval_s = 2.0;
  OdometryNoise noise = jointNoiseDefaults();
  double scale_sigma = 0.1, scale_walk_per_sqrt_m = 0.003;
  /// Of the heading's errors that are the same all the way: [rad/m], and [rad/rad] of turns.
  double heading_per_m = 0.005, heading_per_rad = 0.02;
  /// Of where the body's origin (from which antennas are counted) is in x and y of the body, seen
  /// from what the odometry's poses turn about [m].
  double centre_sigma_m = 0.05;
  double range_worth = 0.15;  ///< of a range among many: their errors are correlated
  int iterations = 30;
  ranging::RobustRange robust;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Joint].
void describe(OptionVisitor& v, JointOptions& o);

struct JointAnchor {
  Vec3 p_C = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};

struct JointSolution {
  bool solved = false;
  std::string problem;  ///< why not
  /// Per robot, in the common world, at every odometry stamp.
  std::vector<std::vector<StampedPose>> trajectories;
  /// Per robot, between its own estimated world and the common one: lays its estimate onto its
  /// trajectory here.
  std::vector<WorldTransform> T_C_W;
  /// Of all T_C_W stacked, (yaw, x, y, z) each.
  Eigen::MatrixXd covariance;
  std::map<std::uint64_t, JointAnchor> anchors;
  int ranges_used = 0, ranges_rejected = 0, iterations = 0;
  bool heights_held = false;  ///< a robot that moves in a plane keeps the height of its start
  double cost = 0;

  /// T between robot `to`'s and robot `from`'s own worlds, with its covariance.
  WorldTransform between(std::size_t to, std::size_t from) const;
  Eigen::Matrix4d covarianceBetween(std::size_t to, std::size_t from) const;
};

/// The first robot's world is the common one (its first pose stays). Deterministic. Bad ranges (not
/// finite, not positive) are left out. Throws as JointOptions::validate().
JointSolution solveJointly(const std::vector<JointRobot>& robots,
                           const std::vector<JointMutualRange>& mutual,
                           const JointOptions& options);

}  // namespace vir::team
