#pragma once
/// Where the search for an anchor begins.
#include <vector>

#include "range_fit.h"

namespace vir::ranging {

/// The path's shape: principal axes, largest extent first.
struct PathShape {
  Vec3 centre = Vec3::Zero();
  Mat3 axes = Mat3::Identity();   ///< columns, unit
  Vec3 deviation = Vec3::Zero();  ///< standard deviation along each axis [m]
  Vec3 extent = Vec3::Zero();     ///< from end to end along each axis [m]
};
PathShape pathShape(const std::vector<Vec3>& path);

/// Closed-form positions, from all ranges and from small subsets (of which some are free of
/// outliers), both mirror images of each; ranked by robust cost, near duplicates left out, at most
/// `count`.
std::vector<FitState> startPositions(const RangeFit& fit, const PathShape& shape,
                                     std::size_t count);

}  // namespace vir::ranging
