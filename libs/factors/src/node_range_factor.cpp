#include "vir/factors/node_range_factor.h"

#include "range_residual.h"

namespace vir::factors {

bool NodeRangeFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  const NodeAntenna antenna(x[0], motion_O_, lever_O_);
  const RangePrediction r = predictRange(antenna.p_W, vec(x[1]), x[1][3], range_.range_m);
  const double scale = whiten(range_, r.value_m, residuals);
  if (!jacobians) return true;
  if (jacobians[0]) nodeJacobian(scale, r.direction, antenna, jacobians[0]);
  if (jacobians[1]) anchorJacobian(scale, r.direction, jacobians[1]);
  return true;
}

}  // namespace vir::factors
