#include "vir/factors/range_factor.h"

#include <algorithm>
#include <cmath>

#include "range_residual.h"

namespace vir::factors {

RangePrediction predictRange(const Vec3& p_W_U, const Vec3& p_W_A, double bias_m, double range_m) {
  const Vec3 d = p_W_U - p_W_A;
  const double distance = d.norm();
  RangePrediction out;
  out.value_m = distance + bias_m - range_m;
  out.direction = d / std::max(distance, kMinDistance);
  return out;
}

double whiten(const RangeTerm& range, double unwhitened_m, double* residuals) {
  // The robust loss knows measured - predicted, the residual is predicted - measured.
  const ranging::RobustRange::Value v = range.robust.evaluate(-unwhitened_m / range.sigma_m);
  residuals[0] = -v.e;
  return v.de_dr / range.sigma_m;
}

NodeFrame::NodeFrame(const double* node)
    : R_W_O(rotZ(node[3])), shrink(std::exp(-node[4])), p_W_B(vec(node)) {}

NodeAntenna::NodeAntenna(const NodeFrame& node, const Vec3& motion_O, const Vec3& lever_O) {
  motion_W = node.R_W_O * (node.shrink * motion_O);
  offset_W = motion_W + node.R_W_O * lever_O;
  p_W = node.p_W_B + offset_W;
}

void nodeJacobian(double scale, const Vec3& direction, const NodeAntenna& antenna, double* j) {
  for (int i = 0; i < 3; ++i) j[i] = scale * direction[i];
  j[3] = scale * direction.dot(turned(antenna.offset_W));
  j[4] = -scale * direction.dot(antenna.motion_W);
}

void anchorJacobian(double scale, const Vec3& direction, double* j) {
  for (int i = 0; i < 3; ++i) j[i] = -scale * direction[i];
  j[3] = scale;
}

}  // namespace vir::factors
