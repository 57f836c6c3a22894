#pragma once
/// Standstill: no velocity, and the same place as before.
#include <ceres/sized_cost_function.h>

#include "vir/geometry/pose.h"

namespace vir::factors {

/// Whitened residual [3] = v / sigma [m/s]. Parameter: speed_bias.
class ZeroVelocityFactor final : public ceres::SizedCostFunction<3, 9> {
 public:
  explicit ZeroVelocityFactor(double sigma_mps) : weight_(1.0 / sigma_mps) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  double weight_;
};

/// Relative pose of j in i: residual [6] = W * (R_i^T (p_j - p_i) - z.p, Log(z.q^-1 q_i^-1 q_j)).
/// Parameters: pose i, pose j.
class RelativePoseFactor final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  RelativePoseFactor(const Pose& T_Bi_Bj, const Eigen::Matrix<double, 6, 6>& sqrt_information)
      : z_(T_Bi_Bj), W_(sqrt_information) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Pose z_;
  Eigen::Matrix<double, 6, 6> W_;
};

}  // namespace vir::factors
