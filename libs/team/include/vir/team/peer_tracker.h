#pragma once
/// Keeps the transforms to other robots' worlds up to date while an estimator runs, from what came
/// over the air alone: own estimates, own ranges, and what the other robots broadcast with them.
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "vir/core/log.h"
#include "vir/team/pairing.h"
#include "vir/team/peer_result.h"
#include "vir/types/frame_change.h"

namespace vir::team {

/// Stands for the robot itself in PairTransform::to.
constexpr const char* kThisRobot = "this";

/// A solver that is ready for ranges; what it has to say goes to `log`.
using PairSolverFactory = std::function<std::unique_ptr<PairSolver>(const LogSink& log)>;

struct PeerTrackerOptions {
  double interval_s = 0.5;  ///< between two answers of a pair
  bool use_anchors = true;  ///< those that both robots know
  /// The same once the transform is unique, if it is longer: what is left is to follow the drift.
  double settled_interval_s = 2;
  /// Answers of a pair kept for its history; beyond, every second of the older half goes.
  std::size_t max_moments = 2400;
};

/// Follows the other robots of a run. What a range needs, it waits for: an own pose on either side
/// of it, and the broadcast with its stamp or poses of the other robot on either side (which go
/// before broadcasts once there are any). All that comes without is counted. Memory is bounded:
/// beside the transforms' history (`max_moments`), of everything only the last seconds are kept.
///
/// The owner tells what comes in as it comes, then calls use(), and finish() in the end.
class PeerTracker {
 public:
  /// The own anchors as believed now; asked only when a solver is.
  using AnchorsNow = std::function<std::vector<Anchor>()>;

  PeerTracker(const PeerTrackerOptions& options, PairSolverFactory create_solver, LogSink log)
      : options_(options), create_solver_(std::move(create_solver)), log_(std::move(log)) {}

  /// Something with this stamp has come in: what was to come before it is late.
  void advance(TimeNs t);
  void addRange(const Range& peer_range);
  void hear(const PeerBroadcast& broadcast);
  /// In any order; twice is once. What is of an older world than one heard before is left out.
  void hear(const PeerPose& pose);
  /// One that could not be read.
  void countUnusableBroadcast() { ++unusable_; }
  void addState(const StateEstimate& estimate);
  /// Own poses go on in another frame (as of a map): those told before are seen there, and so is
  /// all that was found from them.
  void changeFrame(const FrameChange& change);
  /// Uses or counts every range that has waited long enough.
  void use(const AnchorsNow& anchors);
  /// Nothing more will come: uses what it can, and asks every solver once more.
  void finish(const AnchorsNow& anchors);

  /// Other robots that were ranged to, ordered by id (the others were only overheard).
  std::vector<PeerResult> peers() const;
  /// The same robots' transforms and their history; without the ranges.
  std::vector<PairResult> pairs() const;
  /// Has any robot been ranged to or heard?
  bool met() const { return !peers_.empty(); }
  /// Broadcasts that could not be read, whose numbers are not finite, or of too many anchors.
  long unusableBroadcasts() const { return unusable_; }
  /// Ranges to robots beyond the 32 that are followed.
  long rangesOfTooManyRobots() const { return too_many_; }

 private:
  struct Peer {
    std::unique_ptr<PairSolver> solver;
    std::vector<SentPosition> heard;                 ///< the last seconds, in order of time
    std::vector<KnownPose> path;                     ///< likewise; all of one world
    Vec3 p_B_U = Vec3::Zero();                       ///< its antenna, as last told with a pose
    std::vector<Range> recent;                       ///< the last few ranges
    std::map<std::uint64_t, SentPosition> anchors;   ///< as last heard
    std::vector<std::pair<TimeNs, int>> new_worlds;  ///< from then on it is another segment
    TimeNs first = 0, due = 0, last = 0;             ///< of its ranges
    bool asked = true;                               ///< since the last range
    PeerResult result;
    std::vector<PairMoment> history;
  };

  /// False: what the range needs may still come.
  bool useOrCount(const Range& range, const AnchorsNow& anchors);
  /// Where its antenna was, in which of its worlds; empty where that is not known (yet).
  struct Told {
    SentPosition sent;
    int world = 0;
  };
  static std::optional<Told> toldAt(const Peer& peer, TimeNs t);
  void give(const Range& range, const KnownPose& own, const Told& told, Peer* peer);
  void beginWorld(const PeerPose& pose, Peer* peer);
  void ask(const AnchorsNow& anchors, Peer* peer);
  /// Null where there are too many robots.
  Peer* peerOf(int id);

  PeerTrackerOptions options_;
  PairSolverFactory create_solver_;
  LogSink log_;
  std::map<int, Peer> peers_;
  std::vector<KnownPose> poses_;  ///< own, the last seconds
  std::vector<Range> waiting_;    ///< in order of time
  TimeNs now_ = 0;
  bool finished_ = false;
  long unusable_ = 0, too_many_ = 0;
};

}  // namespace vir::team
