#pragma once
/// A range that a frame of the short window holds. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include <optional>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// Range at a frame j of the short window, whose oldest frame 0 is the node:
/// antenna at p + Rz(yaw - d) (exp(-s) (p_O_j + R_O_j motion - p_O_0) + R_O_j lever), d being how
/// far frame 0 is turned about the vertical of O from where it was when the window was set up. A
/// rigid shift of the whole short window, and a turn about the vertical, change nothing: where the
/// window is in W and how it is turned there is the node's business alone. (Of its own heading in O
/// a window knows the less the longer it has been on its way; ranges that may turn it there do so
/// at no cost, back and forth by metres after an hour.)
/// Parameters: pose of frame 0 [7], pose of frame j [7], node [5], anchor [4].
class WindowRangeFactor final : public ceres::SizedCostFunction<1, 7, 7, 5, 4> {
 public:
  /// `motion_B`: what the body moved from the frame's time to the range's; `lever_B`: antenna in
  /// the body then; both in the body axes of frame j [m]. `q_O_B0`: of frame 0 when the window was
  /// set up; without, d = 0.
  WindowRangeFactor(const RangeTerm& range, const Vec3& motion_B, const Vec3& lever_B,
                    const std::optional<Quat>& q_O_B0 = std::nullopt)
      : range_(range),
        motion_B_(motion_B),
        lever_B_(lever_B),
        offset_B_(motion_B + lever_B),
        q_O_B0_(q_O_B0) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  Vec3 motion_B_, lever_B_, offset_B_;
  std::optional<Quat> q_O_B0_;
};

}  // namespace vir::factors
