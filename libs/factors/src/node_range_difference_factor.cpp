#include "vir/factors/node_range_difference_factor.h"

#include "range_residual.h"

namespace vir::factors {

bool NodeRangeDifferenceFactor::Evaluate(double const* const* x, double* residuals,
                                         double** jacobians) const {
  const NodeAntenna antenna(NodeFrame(x[0]), motion_O_, lever_O_);
  const RangePrediction to_0 = predictRange(antenna.p_W, vec(x[1]), x[1][3], 0);
  const RangePrediction to_1 = predictRange(antenna.p_W, vec(x[2]), x[2][3], 0);
  const double value_m = to_1.value_m - to_0.value_m - difference_.range_m;
  // Either way as a range that is too short.
  const double sign = value_m < 0 ? -1 : 1;
  const double scale = whiten(difference_, sign * value_m, residuals);
  residuals[0] *= sign;
  if (!jacobians) return true;
  if (jacobians[0]) nodeJacobian(scale, to_1.direction - to_0.direction, antenna, jacobians[0]);
  if (jacobians[1]) anchorJacobian(-scale, to_0.direction, jacobians[1]);
  if (jacobians[2]) anchorJacobian(scale, to_1.direction, jacobians[2]);
  return true;
}

}  // namespace vir::factors
