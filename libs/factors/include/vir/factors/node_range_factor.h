#pragma once
/// A range that a node of the long window holds. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// Range at a node of the long window: antenna at p + Rz(yaw) (exp(-s) motion + lever).
/// Parameters: node [5], anchor [4].
class NodeRangeFactor final : public ceres::SizedCostFunction<1, 5, 4> {
 public:
  /// `motion_O`: what the body moved from the node's time to the range's; `lever_O`: antenna in the
  /// body then; both in the odometry's axes [m].
  NodeRangeFactor(const RangeTerm& range, const Vec3& motion_O, const Vec3& lever_O)
      : range_(range), motion_O_(motion_O), lever_O_(lever_O) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  Vec3 motion_O_, lever_O_;
};

}  // namespace vir::factors
