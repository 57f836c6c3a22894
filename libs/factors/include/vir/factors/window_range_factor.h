#pragma once
/// A range that a frame of the short window holds. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// Range at a frame j of the short window, whose oldest frame 0 is the node:
/// antenna at p + Rz(yaw) (exp(-s) (p_O_j + R_O_j motion - p_O_0) + R_O_j lever). A rigid shift of
/// the whole short window changes nothing: where the window is in W is the node's business alone.
/// Parameters: pose of frame 0 [7], pose of frame j [7], node [5], anchor [4].
class WindowRangeFactor final : public ceres::SizedCostFunction<1, 7, 7, 5, 4> {
 public:
  /// `motion_B`: what the body moved from the frame's time to the range's; `lever_B`: antenna in
  /// the body then; both in the body axes of frame j [m].
  WindowRangeFactor(const RangeTerm& range, const Vec3& motion_B, const Vec3& lever_B)
      : range_(range), motion_B_(motion_B), lever_B_(lever_B), offset_B_(motion_B + lever_B) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  Vec3 motion_B_, lever_B_, offset_B_;
};

}  // namespace vir::factors
