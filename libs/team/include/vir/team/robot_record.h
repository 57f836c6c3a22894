#pragma once
/// What is left of a robot's run for those it meets.
#include <optional>
#include <string>
#include <vector>

#include "vir/types/anchor.h"
#include "vir/types/peer_broadcast.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir::team {

/// Stamps closer than this belong together: a range and the broadcast that came with it, or one
/// range in two recordings.
constexpr TimeNs kSameStamp = 2000000;
/// Two reports of one measurement: stamps that belong together, and ranges [m] that are equal as
/// recordings keep them (float).
bool isSameRange(TimeNs t, double range_m, TimeNs other_t, double other_range_m);

/// Where a robot was by its own estimate.
struct KnownPose {
  TimeNs t = 0;
  Pose T_W_B;
  /// Of (position in W [m], rotation on the right [rad]).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int segment = 0;  ///< of the world W; another one is another world
};

/// Appends the estimate's pose. False, and nothing done, where it has none, where it is not finite,
/// and where it is not behind the last one.
bool keepPose(const StateEstimate& estimate, std::vector<KnownPose>* poses);

/// Between the two poses around `t`, with the covariance of the first; empty where there is none
/// within 0.5 s or a new world begins in between.
std::optional<KnownPose> poseAt(const std::vector<KnownPose>& poses, TimeNs t);

/// What a robot believes of an anchor (its stamp is 0); empty if it is not to be relied on.
std::optional<SentPosition> believed(const Anchor& anchor);

/// The robot that a range leads to. Ids of radios have 32 bits; robots' ids are signed.
int robotOf(const Range& peer_range);

struct AnchorSnapshot {
  TimeNs t = 0;
  std::vector<Anchor> anchors;
};

struct RobotRecord {
  std::string name;
  int id = 0;                           ///< as beacon in the others' recordings
  std::vector<KnownPose> poses;         ///< causal
  std::vector<AnchorSnapshot> anchors;  ///< in order of time
  std::vector<Range> peer_ranges;       ///< to other robots, as recorded
  std::vector<Range> anchor_ranges;     ///< as recorded
  std::vector<StampedPose> odometry;    ///< T_O_B as recorded
  bool sees = false;                    ///< images or feature tracks are recorded
  std::vector<Landmark> landmarks;
  std::vector<StampedPose> keyframes;
  Trajectory truth;      ///< for evaluation only
  bool damaged = false;  ///< the recording ends in damage or was cut off

  std::optional<KnownPose> at(TimeNs t) const { return poseAt(poses, t); }
  /// The anchors as believed at `t`; none before the first snapshot.
  const std::vector<Anchor>& anchorsAt(TimeNs t) const;
  /// Is it time for a snapshot of the anchors? One every 0.2 s, from the first pose on.
  bool snapshotDue() const;
  /// With the stamp of the newest pose.
  void takeSnapshot(std::vector<Anchor> now) {
    anchors.push_back({poses.back().t, std::move(now)});
  }
  /// Where its antenna is on it [m], as its own recording says: its ranges to other robots, else
  /// those to anchors (one radio does both). Empty if it has recorded no range.
  std::optional<Vec3> antenna() const;
};

}  // namespace vir::team
