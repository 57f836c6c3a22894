#pragma once
/// What recorded observations say about other robots.
#include <mrpt/obs/CObservation.h>

#include <optional>
#include <string>
#include <vector>

#include "vir/roles/estimator.h"

namespace vir::app {

/// Stamps closer than this belong together: a range and the broadcast that came with it, or one
/// range in two recordings.
constexpr TimeNs kSameStamp = 2000000;

/// A range to another robot as this one measured it.
struct PeerObservation {
  TimeNs t = 0;
  int peer = 0;
  double range_m = 0, sigma_m = 0;
  Vec3 p_B_U = Vec3::Zero();  ///< own antenna
};

/// A position with its covariance in its sender's world.
struct SentPosition {
  TimeNs t = 0;
  Vec3 p_W = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};

/// Who sent a position, and of what.
struct PeerBroadcast {
  int peer = 0;
  std::optional<std::uint64_t> anchor;  ///< empty: of the sender's antenna
  SentPosition sent;
};

struct KnownPose {
  TimeNs t = 0;
  Pose T_W_B;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int segment = 0;
};

/// Ranges of an observation with the label `peer_label`; none for any other.
std::vector<PeerObservation> peerRangesOf(const mrpt::obs::CObservation& observation,
                                          const std::string& peer_label);

/// Of an observation with the label `<peer_label>:<id>` or `<peer_label>:<id>:ANCHOR:<a>`. A label
/// that only begins so, and a position that is not finite, counts in `unusable`.
std::optional<PeerBroadcast> broadcastOf(const mrpt::obs::CObservation& observation,
                                         const std::string& peer_label, long* unusable);

/// Between the two poses around `t`; empty where there is none within 0.5 s or a new world begins
/// in between.
std::optional<KnownPose> poseAt(const std::vector<KnownPose>& poses, TimeNs t);

/// What a robot believes of an anchor; empty if it is not to be relied on.
std::optional<SentPosition> believed(const Anchor& anchor);

}  // namespace vir::app
