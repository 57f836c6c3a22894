#pragma once
/// What the odometry says of two nodes of the long window. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/geometry/pose.h"

namespace vir::factors {

/// Motion of the odometry from node a to node b, residual [5]:
///   W * ( Rz(-yaw_a) (p_b - p_a) - exp(-s_a) motion_O ; yaw_b - yaw_a ),  (s_b - s_a) / sigma_s
/// `sqrt_information` W [4x4] belongs to (motion in O [m], yaw [rad]).
/// Parameters: node a [5], node b [5].
/// The same without an object for each edge: evaluateNodeEdge().
class NodeEdgeFactor final : public ceres::SizedCostFunction<5, 5, 5> {
 public:
  NodeEdgeFactor(const Vec3& motion_O, const Eigen::Matrix4d& sqrt_information,
                 double sigma_log_scale)
      : motion_O_(motion_O), W_(sqrt_information), sigma_s_(sigma_log_scale) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Vec3 motion_O_;
  Eigen::Matrix4d W_;
  double sigma_s_;
};

/// What NodeEdgeFactor evaluates: residual [5] and, unless null, its Jacobians [5x5, by rows].
void evaluateNodeEdge(const Vec3& motion_O, const Eigen::Matrix4d& sqrt_information,
                      double sigma_log_scale, const double* node_a, const double* node_b,
                      double* residuals, double* J_a, double* J_b);

}  // namespace vir::factors
