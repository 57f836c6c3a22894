#pragma once
/// What one range says about the yaw when both robots know an anchor (section "Distributed
/// Collaborative SLAM"; the height follows from the anchor's).
#include <array>

#include "vir/team/world_transform.h"

namespace vir::team {

enum class YawProblem {
  none,
  on_the_vertical,  ///< of the anchor, as far as the range's sigma can tell: any yaw fits
  does_not_fit,     ///< longer or shorter than any yaw allows by more than three sigmas
};

struct YawPair {
  YawProblem problem = YawProblem::on_the_vertical;
  std::array<double, 2> yaw_rad{};  ///< equal where the two meet
};

/// The two intersections of the circle around the anchor on which B lies and the sphere around A.
YawPair yawsFromRange(const MutualRange& range, const SharedAnchor& anchor);

/// The transform with this yaw that lays the anchor's two positions onto each other.
WorldTransform throughAnchor(double yaw_rad, const SharedAnchor& anchor);

}  // namespace vir::team
