#include "vir/factors/range_factor.h"

#include <algorithm>

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

void anchorJacobian(double scale, const Vec3& direction, double* j) {
  for (int i = 0; i < 3; ++i) j[i] = -scale * direction[i];
  j[3] = scale;
}

}  // namespace vir::factors
