#include "vir/factors/node_range_factor.h"

#include <cmath>

#include "range_residual.h"

namespace vir::factors {

bool NodeRangeFactor::Evaluate(double const* const* x, double* residuals,
                               double** jacobians) const {
  const Mat3 R = rotZ(x[0][3]);
  const double shrink = std::exp(-x[0][4]);
  const Vec3 motion_W = R * (shrink * motion_O_);
  const Vec3 offset_W = motion_W + R * lever_O_;
  const RangePrediction r = predictRange(vec(x[0]) + offset_W, vec(x[1]), x[1][3], range_.range_m);
  const double scale = whiten(range_, r.value_m, residuals);
  if (!jacobians) return true;
  if (jacobians[0]) {
    for (int i = 0; i < 3; ++i) jacobians[0][i] = scale * r.direction[i];
    jacobians[0][3] = scale * r.direction.dot(turned(offset_W));
    jacobians[0][4] = -scale * r.direction.dot(motion_W);
  }
  if (jacobians[1]) anchorJacobian(scale, r.direction, jacobians[1]);
  return true;
}

}  // namespace vir::factors
