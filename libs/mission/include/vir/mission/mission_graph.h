#pragma once
/// The whole path as a graph: keyframes with what the estimator says of the way between them and of
/// where they are, and places that were seen twice.
///
/// Frames: W is the estimator's world, whose path may have drifted; M is the mission's, where it
/// has not. A keyframe is where the estimator has it, moved level: roll and pitch stay. Where
/// ranges to anchors hold the path, the estimator's covariance stays small; the graph then ties
/// keyframes to W as strongly as that says, and loops correct little.
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "vir/core/options.h"
#include "vir/geometry/level_transform.h"
#include "vir/types/loop.h"
#include "vir/types/state.h"

namespace vir::mission {

struct GraphOptions {
  double drift_m_per_sqrt_m = 0.02;
  double drift_rad_per_sqrt_m = 0.002;
  double loop_sigma_m = 0.03;
  double loop_sigma_rad = 0.005;
  double lost_m = 2;
  double lost_mps = 5;
  double gate = 18.5;
  double second_opinion = 10;
  double opinion_m = 1.0;
  int iterations = 6;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Mission].
void describe(OptionVisitor& v, GraphOptions& o);

/// A keyframe as the estimator has it.
struct PathNode {
  std::uint64_t id = 0;  ///< rises
  TimeNs t = 0;
  int segment = 0;  ///< as of `StateEstimate`
  Pose T_W_B;
  /// Of (position in W [m], rotation on the right [rad]); zero if unknown.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  TimeNs segment_since = 0;  ///< what is at or after this belongs to its segment
  bool held = false;         ///< by ranges to anchors: what shrinks of the covariance is known in W
  /// By a single anchor, about whose vertical everything may turn, and whose place comes from the
  /// path itself: W moves as the anchor becomes known. See takeOdometry().
  bool pivots = false;
};

/// A keyframe as images and IMU alone have it.
struct Odometry {
  Pose T_O_B;  ///< in a world of its own, z up [m of W]
  /// Of way [m^2] and turn about the vertical [rad^2], summed up since some earlier keyframe. What
  /// does not grow between two is not known.
  Eigen::Vector4d variance = Eigen::Vector4d::Zero();
};

enum class LoopState {
  accepted,
  waiting,    ///< contradicts what is known, or joins what nothing holds together: to be seconded
  refused,    ///< cannot be
  taken_back  ///< was accepted; what came later contradicts it
};
/// As written in loops.csv.
const char* name(LoopState state);

struct JudgedLoop {
  Loop loop;
  TimeNs t_older = 0, t_newer = 0;
  LoopState state = LoopState::waiting;
  /// Against what the graph knew when it came, of four degrees of freedom; below 0: it knew
  /// nothing.
  double chi2 = -1;
};

struct LoopCounts {
  long accepted = 0, waiting = 0, refused = 0, taken_back = 0;
};

class MissionGraph {
 public:
  /// Throws what `options.validate()` throws.
  explicit MissionGraph(const GraphOptions& options);
  ~MissionGraph();
  MissionGraph(MissionGraph&&) noexcept;
  MissionGraph& operator=(MissionGraph&&) noexcept;

  /// A keyframe of a map, before all others: it stays at T_M_B.
  void addFixed(std::uint64_t id, TimeNs t, const Pose& T_M_B);
  /// The next keyframe, where the last correction puts it. Throws std::invalid_argument if its id
  /// is not above the last one's or its numbers are not finite.
  void add(const PathNode& node);
  /// The estimator has a keyframe elsewhere by now; unknown and fixed ones are passed over.
  void move(std::uint64_t id, const Pose& T_W_B, const std::optional<Odometry>& odometry = {});

  /// From now on, where loops act, keyframes that pivot are tied by their odometry and not to W:
  /// better for the path as a whole, while the newest pose is better off in W.
  void takeOdometry();

  /// The referee: may it act? A loop of unknown keyframes, or with numbers that cannot be, is
  /// refused. Others that wait may be accepted with it.
  LoopState offer(const Loop& loop);
  /// An accepted loop pulls at the path by more than it may be wrong.
  bool solveDue() const;
  /// Gauss-Newton on everything. Loops that the rest contradicts are taken back, and back in when
  /// it does not any more.
  void solve();

  bool empty() const;
  /// T_M_W at the newest keyframe.
  LevelTransform correction() const;
  /// Likewise at a time of the run, between its neighbours by time.
  LevelTransform correctionAt(TimeNs t) const;
  /// Of the run's keyframes (not a map's), in M.
  std::vector<StampedPose> path() const;
  std::optional<Pose> poseOf(std::uint64_t id) const;  ///< T_M_B
  /// Is the newest keyframe tied to the oldest, without a gap that no loop has closed?
  bool joined() const;
  /// What the graph says of the newer as seen from the older, without the loops that wait, and its
  /// covariance of (motion in the older's W [m], turn [rad]).
  struct Relative {
    Vec3 motion_W = Vec3::Zero();
    double turn_rad = 0;
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  };
  /// Nothing for keyframes that are unknown or not tied to one another.
  std::optional<Relative> relative(std::uint64_t older, std::uint64_t newer) const;

  /// How well the newest keyframe is known in M, by path and loops together, of (position in M [m],
  /// yaw [rad]); nothing before a loop acts, where nothing ties it to the oldest, or where the path
  /// proved better than the loops.
  std::optional<Eigen::Matrix4d> covariance() const;

  const std::vector<JudgedLoop>& loops() const;
  LoopCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::mission
