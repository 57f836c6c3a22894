#pragma once
/// Where should somebody go next, so that ranges to an anchor tell where it is?
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "vir/geometry/pose.h"

namespace vir::ranging {

/// A position that explains an anchor's ranges so far, and what is unknown of it.
struct AnchorHypothesis {
  Vec3 p_W = Vec3::Zero();             ///< [m]
  Mat3 covariance = Mat3::Identity();  ///< [m^2]
};

struct Waypoint {
  Vec3 step_W = Vec3::Zero();  ///< from where one is [m]
  double told_m =
      0;  ///< standard deviation of what the positions in question say of the range there
};

/// The shortest of a few straight steps (up and down by 0.5 to 3 m, never below `lowest_z_m` in W;
/// eight level ones of 0.5 to 8 m) at whose end the
/// positions in question say ranges that differ by `sufficient_m` (one standard deviation); where
/// none does, the one that tells most. Of each hypothesis the points at sqrt(3) sigma on the
/// covariance's axes are asked, brought to the distance that is measured from here: along the line
/// of sight nothing is in question. What counts is how the range changes with the step, so that a
/// constant bias does not matter. Nothing where no step tells more than a third of `sufficient_m`,
/// and for input that is not finite.
std::optional<Waypoint> nextWaypoint(const Vec3& from_W,
                                     const std::vector<AnchorHypothesis>& hypotheses,
                                     double sufficient_m,
                                     double lowest_z_m = -std::numeric_limits<double>::infinity());

}  // namespace vir::ranging
