#include "vir/factors/node_range_factor.h"

#include "range_residual.h"

namespace vir::factors {

void evaluateNodeRange(const RangeTerm& range, const NodeFrame& node, const Vec3& motion_O,
                       const Vec3& lever_O, const double* anchor, double* residual, double* J_node,
                       double* J_anchor) {
  const NodeAntenna antenna(node, motion_O, lever_O);
  const RangePrediction r = predictRange(antenna.p_W, vec(anchor), anchor[3], range.range_m);
  const double scale = whiten(range, r.value_m, residual);
  if (J_node) nodeJacobian(scale, r.direction, antenna, J_node);
  if (J_anchor) anchorJacobian(scale, r.direction, J_anchor);
}

bool NodeRangeFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  evaluateNodeRange(range_, NodeFrame(x[0]), motion_O_, lever_O_, x[1], residuals,
                    jacobians ? jacobians[0] : nullptr, jacobians ? jacobians[1] : nullptr);
  return true;
}

}  // namespace vir::factors
