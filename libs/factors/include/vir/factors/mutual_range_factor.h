#pragma once
/// Ranges of robots whose centre is not known exactly, between two of them or to an anchor. Blocks
/// of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// Where a node has its antenna at the time of a range:
///   p + Rz(yaw) (exp(-s) motion + lever + axes_O centre)
/// in the node's odometry's axes [m].
struct AntennaAtNode {
  using Axes = Eigen::Matrix<double, 3, 2>;
  Vec3 motion_O = Vec3::Zero();  ///< what the body moved from the node's time to the range's
  Vec3 lever_O = Vec3::Zero();   ///< antenna in the body then
  /// x and y of the body then. What turns with the odometry's poses need not be the body's origin:
  /// `centre` [2], a block of parameters, is where the origin is from there [m], in x and y of the
  /// body, the same all the way.
  Axes axes_O = Axes::Zero();
};

/// |p_W_U1 - p_W_U2| - range, robust as every range. Parameters: first node [5], second node [5],
/// centre of the first [2], of the second [2].
class MutualRangeFactor final : public ceres::SizedCostFunction<1, 5, 5, 2, 2> {
 public:
  MutualRangeFactor(const RangeTerm& range, const AntennaAtNode& first, const AntennaAtNode& second)
      : range_(range), first_(first), second_(second) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  AntennaAtNode first_, second_;
};

/// The same to an anchor. Parameters: node [5], anchor [4], centre [2].
class CentredRangeFactor final : public ceres::SizedCostFunction<1, 5, 4, 2> {
 public:
  CentredRangeFactor(const RangeTerm& range, const AntennaAtNode& antenna)
      : range_(range), antenna_(antenna) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  AntennaAtNode antenna_;
};

}  // namespace vir::factors
