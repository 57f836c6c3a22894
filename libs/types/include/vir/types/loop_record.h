#pragma once
#include <string>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"

namespace vir {
inline namespace types {

/// A place that may have been seen before, and what was decided: a row of loops.csv.
struct LoopRecord {
  TimeNs t_older = 0, t_newer = 0;
  bool accepted = false;
  bool in_map = false;   ///< the older keyframe is one of the map that was loaded
  std::string decision;  ///< "accepted", or why not
  /// Squared distance to what odometry and ranges say, four degrees of freedom; below 0: they said
  /// nothing.
  double chi2 = -1;
  int matches = 0, inliers = 0;
  Vec3 p_older = Vec3::Zero(), p_newer = Vec3::Zero();  ///< of the bodies, as known in the end [m]
  Pose T_older_newer;                                   ///< as the images say, body to body
};

}  // namespace types
}  // namespace vir
