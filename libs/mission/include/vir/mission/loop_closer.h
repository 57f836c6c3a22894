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

  /// Whether add() would take a keyframe of this state: those too near to the last one are not.
  bool wants(const StateEstimate& estimate) const;
  void add(const SeenKeyframe& keyframe);
  /// A solution is worth its time.
  bool solveDue() const;
  /// `keyframes`: all as the estimator has them by now, in order of time.
  /// `last`: no keyframe comes after it.
  void solve(const std::vector<FollowedPose>& keyframes, bool last = false);

  /// T_M_W now, and at a time of the run.
  LevelTransform correction() const;
  LevelTransform correctionAt(TimeNs t) const;
  /// A state not older than the newest keyframe, from W to M. Where loops make its position known
  /// better than the estimator has it, its covariance becomes that of path and loops together.
  void correct(StateEstimate* estimate) const;
  /// Keyframes that the last solution moved by more than a millimetre, in M; none since it was last
  /// asked: nothing.
  std::optional<Revision> takeRevision();
  /// Is any loop accepted? Else M is W.
  bool acts() const;
  /// False as long as a map was loaded and the run was not found in it.
  bool found() const;
  /// The run was not found yet and has just begun: keyframes are wanted more often, and those
  /// without landmarks too.
  bool searching() const;

  std::vector<LoopRecord> records() const;
  /// Second visits that were looked at and did not count; those of a lone keyframe included.
  long rejected() const;
  std::vector<std::pair<std::string, long>> counters() const;
  /// Corners with a known distance, in M.
  std::vector<Landmark> landmarks() const;
  /// The map that was loaded and what this run adds to it; this run alone where it was not found.
  /// `anchors`: in M.
  MissionMap map(const Calibration& calibration, const std::vector<Anchor>& anchors) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::mission
