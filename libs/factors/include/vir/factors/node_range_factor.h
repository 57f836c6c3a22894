#pragma once
/// A range that a node of the long window holds. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// How a node of the long window lies in W: once for all that it holds.
struct NodeFrame {
  explicit NodeFrame(const double* node);
  Mat3 R_W_O;     ///< Rz(yaw)
  double shrink;  ///< exp(-log scale)
  Vec3 p_W_B;
};

/// What NodeRangeFactor evaluates, without an object for each range: residual and, unless null, its
/// Jacobians for the node [5] and the anchor [4].
void evaluateNodeRange(const RangeTerm& range, const NodeFrame& node, const Vec3& motion_O,
                       const Vec3& lever_O, const double* anchor, double* residual, double* J_node,
                       double* J_anchor);

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
