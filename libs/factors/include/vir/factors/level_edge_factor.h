#pragma once
/// How two keyframes of the mission's graph lie to one another, roll and pitch being known from
/// gravity. Block of a keyframe [4]: p_M_B [m], yaw of W in M there [rad]; W is the world of the
/// estimator that the keyframe's axes were given in, M the corrected one. Both have z up. A block
/// may also be W itself: where its origin is in M.
#include <ceres/sized_cost_function.h>

#include "vir/geometry/pose.h"

namespace vir::factors {

/// Residual [4], the turn between -pi and pi:
///   W ( Rz(-yaw_a) (p_b - p_a) - motion_W ; yaw_b - yaw_a - turn )
/// `sqrt_information` W [4x4] belongs to (motion in a's W [m], turn [rad]).
class LevelEdgeFactor final : public ceres::SizedCostFunction<4, 4, 4> {
 public:
  LevelEdgeFactor(const Vec3& motion_W, double turn_rad, const Eigen::Matrix4d& sqrt_information)
      : motion_W_(motion_W), turn_rad_(turn_rad), W_(sqrt_information) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Vec3 motion_W_;
  double turn_rad_;
  Eigen::Matrix4d W_;
};

}  // namespace vir::factors
