#pragma once
/// A range between two robots, each at a node of its own. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// Where a node has its antenna at the time of a range: p + Rz(yaw) (exp(-s) motion + lever), in
/// the node's odometry's axes [m].
struct AntennaAtNode {
  Vec3 motion_O = Vec3::Zero();  ///< what the body moved from the node's time to the range's
  Vec3 lever_O = Vec3::Zero();   ///< antenna in the body then
};

/// |p_W_U1 - p_W_U2| - range, robust as every range. Parameters: first node [5], second node [5].
class MutualRangeFactor final : public ceres::SizedCostFunction<1, 5, 5> {
 public:
  MutualRangeFactor(const RangeTerm& range, const AntennaAtNode& first, const AntennaAtNode& second)
      : range_(range), first_(first), second_(second) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  AntennaAtNode first_, second_;
};

}  // namespace vir::factors
