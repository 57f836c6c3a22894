#pragma once
/// Ranges of several robots that share one radio channel: to anchors, and to each other with what
/// each tells about itself.
#include <memory>
#include <vector>

#include "vir/simulation/simulate_odometry.h"
#include "vir/simulation/simulate_ranges.h"

namespace vir::simulation {

struct TeamRangeOptions {
  double peer_rate_hz = 5;      ///< per pair of robots; 0 = no ranges between robots
  double anchor_known_s = 8;    ///< a robot tells of anchors from then on
  double anchor_sigma_m = 0.1;  ///< how well it knows them, per axis
};
/// Section [SimulatedTeam].
void describe(OptionVisitor& v, TeamRangeOptions& o);

struct TeamRobot {
  int id = 0;
  std::shared_ptr<const Motion> motion;
};

/// A position a robot tells, in its own world O (z up, begins at its first pose).
struct ToldPosition {
  int anchor = -1;  ///< id; -1: the robot itself
  Vec3 p_O = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();  ///< [m^2]
};

struct PeerRange {
  SimulatedRange range;  ///< `anchor` is the other robot's id
  /// What the other robot says at this time: the position of its antenna, then of its anchors.
  std::vector<ToldPosition> told;
};

struct RobotRanges {
  std::vector<SimulatedRange> anchors;  ///< in time order
  std::vector<PeerRange> peers;         ///< in time order
  /// True transform to W from the world in which the robot tells its positions, at the beginning.
  Pose T_W_O;
};

/// Two-way ranging by turns: a period of 1 / (the higher of the two rates) is divided into one slot
/// per pair (robot and anchor, or robot and robot), so that no two ranges are at the same time.
/// Both robots get a range between them. Errors as in `options`, between robots as well;
/// lever_arm_m is that of all. What a robot tells comes from simulateOdometry with `odometry` (its
/// seed counts up per robot). In the order of `robots`. Throws std::invalid_argument for settings
/// that make no sense together and for ids that occur twice.
std::vector<RobotRanges> simulateTeamRanges(const std::vector<TeamRobot>& robots,
                                            const RangeSimulationOptions& options,
                                            const TeamRangeOptions& team,
                                            const OdometrySimulationOptions& odometry,
                                            const rendering::Scene* scene);

}  // namespace vir::simulation
