#pragma once
/// Second visits in a running mission: keyframes go in, corrections of the estimator's world come
/// out. Corrections move W against M; they never touch what the estimator works with.
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/log.h"
#include "vir/mission/mission_graph.h"
#include "vir/mission/mission_map.h"
#include "vir/places/describer.h"
#include "vir/places/loop_finder.h"
#include "vir/types/followed_pose.h"
#include "vir/types/image.h"
#include "vir/types/loop_record.h"

namespace vir::mission {

struct LoopOptions {
  double interval_s = 0.3;
  double moved_m = 0.05;
  double turned_rad = 0.1;
  double pause_m = 1.0;
  double max_landmark_sigma = 0.05;
  places::DescriberOptions describer;
  places::PlaceIndexOptions index;
  places::VerifyOptions verify;
  places::LoopFinderOptions finder;
  GraphOptions graph;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Sections [Loops], [Places], [PlaceIndex], [LoopCheck], [Mission].
void describe(OptionVisitor& v, LoopOptions& o);

/// A keyframe as it is when it is the newest image.
struct SeenKeyframe {
  Image gray;  ///< used during the call only
  StateEstimate estimate;
  std::vector<places::SeenLandmark> landmarks;
  TimeNs segment_since = 0;  ///< see PathNode
  bool held = false;         ///< likewise
  /// By two anchors or more: a single one leaves open a turn of everything about its vertical.
  bool turn_held = false;
};

/// Which states become keyframes of the mission: those too near to the last one do not.
class KeyframePace {
 public:
  /// A run that begins with a map is looked for so long.
  static constexpr double kSearch_s = 10;

  explicit KeyframePace(const LoopOptions& options) : options_(options) {}
  /// `found`: as of LoopCloser. A run that was not found yet and has just begun: more often.
  bool wants(const StateEstimate& estimate, bool found) const;
  bool searches(bool found) const;
  void took(const StateEstimate& estimate);
  /// Is the last one that was taken of so much time after the first?
  bool within(double seconds) const;

 private:
  LoopOptions options_;
  std::optional<StampedPose> last_;
  TimeNs first_ = 0;
  int segment_ = 0;
};

/// From W to M, as far as loops have told by some keyframe.
struct Correction {
  LevelTransform T_M_W;
  /// Where loops make a position known better than the estimator has it: what the covariance of
  /// (position [m], yaw [rad]) in M is transported by.
  std::optional<Eigen::Matrix4d> known;

  /// Of a state not older than that keyframe. Its covariance becomes that of path and loops
  /// together.
  void apply(StateEstimate* estimate) const;
};

/// Not for two threads at a time: it may have a thread of its own, which then makes all the calls.
/// The same calls give the same answers.
class LoopCloser {
 public:
  /// Throws std::invalid_argument for options or a camera that cannot be.
  LoopCloser(const LoopOptions& options, const Calibration& calibration, LogSink log = {});
  ~LoopCloser();

  /// Before any keyframe: the run is looked for in this map, and continues in its frame from then
  /// on. Throws std::invalid_argument if the map is of another camera.
  void begin(const MissionMap& map);

  /// The run's anchors, in W, as they are known by now. With a map that knows them they say where
  /// to look in it: two or more where the robot is, a single one what cannot be. Nothing once the
  /// run was found.
  void setAnchors(const std::vector<Anchor>& in_W);

  /// Those too near to the last one are passed over: see KeyframePace.
  void add(const SeenKeyframe& keyframe);
  /// A solution is worth its time.
  bool solveDue() const;
  /// `keyframes`: all as the estimator has them by now, in order of time.
  /// `last`: no keyframe comes after it.
  void solve(const std::vector<FollowedPose>& keyframes, bool last = false);

  /// T_M_W now, and at a time of the run.
  LevelTransform correction() const;
  LevelTransform correctionAt(TimeNs t) const;
  /// Of states from the newest keyframe on.
  Correction now() const;
  /// Keyframes that the last solution moved by more than a millimetre, in M; none since it was last
  /// asked: nothing.
  std::optional<Revision> takeRevision();
  /// Is any loop accepted? Else M is W.
  bool acts() const;
  /// False as long as a map was loaded and the run was not found in it.
  bool found() const;

  std::vector<LoopRecord> records() const;
  /// Second visits that were looked at and did not count; those of a lone keyframe included.
  long rejected() const;
  std::vector<std::pair<std::string, long>> counters() const;
  /// Corners with a known distance, in M.
  std::vector<Landmark> landmarks() const;
  /// The map that was loaded and what this run adds to it; this run alone where it was not found.
  /// As many keyframes as `PlaceIndexOptions::max_keyframes` allows, without what others show.
  /// `anchors`: in M.
  MissionMap map(const Calibration& calibration, const std::vector<Anchor>& anchors) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::mission
