#pragma once
/// The paper's tie between nodes of the long window. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/geometry/pose.h"

namespace vir::factors {

/// The paper's virtual relative measurement: gamma_s (p_b - p_a - z), residual [3]; yaw and scale
/// play no part. Parameters: node a [5], node b [5].
class PositionLinkFactor final : public ceres::SizedCostFunction<3, 5, 5> {
 public:
  PositionLinkFactor(const Vec3& z_W, double gamma_s) : z_W_(z_W), gamma_s_(gamma_s) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Vec3 z_W_;
  double gamma_s_;
};

}  // namespace vir::factors
