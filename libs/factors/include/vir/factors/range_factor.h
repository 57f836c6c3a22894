#pragma once
/// Ranges to anchors and the edges of the long window (paper, "UWB Factor").
///
/// A node of the long window is a keyframe of the odometry with a correction: where it is in W and
/// how the odometry's axes O are turned in W there. Roll and pitch stay the odometry's.
///
/// node   [5]  p_W_B [m], yaw of O in W [rad], log of the odometry's scale
/// anchor [4]  p_W_A [m], bias of its ranges [m]
///
/// A vector d_O of the odometry stands for Rz(yaw) exp(-log_scale) d_O in W.
#include <ceres/sized_cost_function.h>

#include "vir/geometry/pose.h"
#include "vir/ranging/robust_range.h"

namespace vir::factors {

/// One range as its factors need it.
struct RangeTerm {
  double range_m = 0;  ///< bias that depends on the distance already taken off
  double sigma_m = 0.1;
  ranging::RobustRange robust;
};

/// Distance, kept away from zero so that its direction is defined: below this [m] the range says
/// nothing about direction, and the Jacobian fades out.
constexpr double kMinDistance = 0.05;

/// Unwhitened range residual: |p_W_U - p_W_A| + bias - range, with the direction from the anchor to
/// the antenna (zero vector at zero distance, unit length beyond kMinDistance).
struct RangePrediction {
  double value_m = 0;
  Vec3 direction = Vec3::Zero();
};
RangePrediction predictRange(const Vec3& p_W_U, const Vec3& p_W_A, double bias_m, double range_m);

/// Range at a node of the long window: antenna at p + Rz(yaw) (exp(-s) motion + lever).
/// Parameters: node [5], anchor [4].
class NodeRangeFactor final : public ceres::SizedCostFunction<1, 5, 4> {
 public:
  /// `motion_O`: what the body moved from the node's time to the range's; `lever_O`: antenna in the
  /// body then; both in the odometry's axes [m].
  NodeRangeFactor(const RangeTerm& range, const Vec3& motion_O, const Vec3& lever_O)
      : range_(range), motion_O_(motion_O), lever_O_(lever_O) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  Vec3 motion_O_, lever_O_;
};

/// Range at a frame j of the short window, whose oldest frame 0 is the node:
/// antenna at p + Rz(yaw) (p_O_j + R_O_j offset - p_O_0). A rigid shift of the whole short window
/// changes nothing: where the window is in W is the node's business alone.
/// Parameters: pose of frame 0 [7], pose of frame j [7], node [5], anchor [4].
class WindowRangeFactor final : public ceres::SizedCostFunction<1, 7, 7, 5, 4> {
 public:
  /// `offset_B`: antenna at the range's time in the body frame of frame j [m].
  WindowRangeFactor(const RangeTerm& range, const Vec3& offset_B)
      : range_(range), offset_B_(offset_B) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  Vec3 offset_B_;
};

/// The same at frame 0 itself. Parameters: pose of frame 0 [7], node [5], anchor [4].
class FrontRangeFactor final : public ceres::SizedCostFunction<1, 7, 5, 4> {
 public:
  FrontRangeFactor(const RangeTerm& range, const Vec3& offset_B)
      : range_(range), offset_B_(offset_B) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  Vec3 offset_B_;
};

/// Motion of the odometry from node a to node b, residual [5]:
///   W * ( Rz(-yaw_a) (p_b - p_a) - exp(-s_a) motion_O ; yaw_b - yaw_a ),  (s_b - s_a) / sigma_s
/// `sqrt_information` W [4x4] belongs to (motion in O [m], yaw [rad]).
/// Parameters: node a [5], node b [5].
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
