#pragma once
/// The pose between two level frames that explains its matches best, and how well it is known.
#include "loop_pose.h"

namespace vir::places {

struct RefinedPose {
  Pose T_older_newer;  ///< newer level frame to older level frame
  /// Of (position in the older level frame [m], rotation on the right [rad]).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  bool valid = false;
};

/// Six degrees of freedom; roll and pitch are held by the vertical of both sides.
RefinedPose refinePose(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                       const Pose& T_older_newer, const VerifyOptions& options);

/// What a pose says is in view of the other side is looked for there, in both directions.
struct GuidedMatches {
  std::vector<PointMatch> matches;
  /// Points of the newer and the older keyframe (not its neighbours) that the other must see.
  int in_view = 0;
};
GuidedMatches matchGuided(const LevelPlaces& places, const Pose& T_older_newer,
                          const VerifyOptions& options);

}  // namespace vir::places
