#include "vir/factors/mutual_range_factor.h"

#include "range_residual.h"

namespace vir::factors {

bool MutualRangeFactor::Evaluate(double const* const* x, double* residuals,
                                 double** jacobians) const {
  const NodeAntenna first(NodeFrame(x[0]), first_.motion_O, first_.lever_O);
  const NodeAntenna second(NodeFrame(x[1]), second_.motion_O, second_.lever_O);
  const RangePrediction r = predictRange(first.p_W, second.p_W, 0, range_.range_m);
  const double scale = whiten(range_, r.value_m, residuals);
  if (!jacobians) return true;
  if (jacobians[0]) nodeJacobian(scale, r.direction, first, jacobians[0]);
  if (jacobians[1]) nodeJacobian(-scale, r.direction, second, jacobians[1]);
  return true;
}

}  // namespace vir::factors
