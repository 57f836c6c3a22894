#include "vir/factors/mutual_range_factor.h"

#include "range_residual.h"

namespace vir::factors {

namespace {

Vec3 leverOf(const AntennaAtNode& antenna, const double* centre) {
  return antenna.lever_O + antenna.axes_O * Eigen::Vector2d(centre[0], centre[1]);
}

void centreJacobian(double scale, const Vec3& direction, const NodeFrame& node,
                    const AntennaAtNode& antenna, double* j) {
  Eigen::Map<Eigen::Matrix<double, 1, 2>>(j).noalias() =
      scale * (direction.transpose() * node.R_W_O) * antenna.axes_O;
}

}  // namespace

bool MutualRangeFactor::Evaluate(double const* const* x, double* residuals,
                                 double** jacobians) const {
  const NodeFrame at_first(x[0]), at_second(x[1]);
  const NodeAntenna first(at_first, first_.motion_O, leverOf(first_, x[2]));
  const NodeAntenna second(at_second, second_.motion_O, leverOf(second_, x[3]));
  const RangePrediction r = predictRange(first.p_W, second.p_W, 0, range_.range_m);
  const double scale = whiten(range_, r.value_m, residuals);
  if (!jacobians) return true;
  if (jacobians[0]) nodeJacobian(scale, r.direction, first, jacobians[0]);
  if (jacobians[1]) nodeJacobian(-scale, r.direction, second, jacobians[1]);
  if (jacobians[2]) centreJacobian(scale, r.direction, at_first, first_, jacobians[2]);
  if (jacobians[3]) centreJacobian(-scale, r.direction, at_second, second_, jacobians[3]);
  return true;
}

bool CentredRangeFactor::Evaluate(double const* const* x, double* residuals,
                                  double** jacobians) const {
  const NodeFrame node(x[0]);
  const NodeAntenna antenna(node, antenna_.motion_O, leverOf(antenna_, x[2]));
  const RangePrediction r = predictRange(antenna.p_W, vec(x[1]), x[1][3], range_.range_m);
  const double scale = whiten(range_, r.value_m, residuals);
  if (!jacobians) return true;
  if (jacobians[0]) nodeJacobian(scale, r.direction, antenna, jacobians[0]);
  if (jacobians[1]) anchorJacobian(scale, r.direction, jacobians[1]);
  if (jacobians[2]) centreJacobian(scale, r.direction, node, antenna_, jacobians[2]);
  return true;
}

}  // namespace vir::factors
