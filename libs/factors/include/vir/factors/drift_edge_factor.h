#pragma once
/// An edge of the odometry whose heading errs in proportion to the way and to the turns: wheels of
/// different size, a wrong wheelbase, a gyro's scale. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/factors/node_edge_factor.h"

namespace vir::factors {

/// As NodeEdgeFactor, the yaw of O in W growing by what the heading of the odometry misses [5]:
///   yaw_b - yaw_a - (d_m metres + d_rad turn_rad)
/// Parameters: node a [5], node b [5], drift [2]: d_m [rad/m] and d_rad [rad/rad], the same for a
/// robot's whole path. `turn_rad`: the heading's change from a to b by the odometry, with sign.
class DriftEdgeFactor final : public ceres::SizedCostFunction<5, 5, 5, 2> {
 public:
  DriftEdgeFactor(const Vec3& motion_O, const Eigen::Matrix4d& sqrt_information,
                  double sigma_log_scale, double metres, double turn_rad)
      : edge_(motion_O, sqrt_information, sigma_log_scale),
        weight_(sqrt_information.col(3)),
        metres_(metres),
        turn_rad_(turn_rad) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  NodeEdgeFactor edge_;
  Eigen::Vector4d weight_;  // of an error in yaw
  double metres_, turn_rad_;
};

}  // namespace vir::factors
