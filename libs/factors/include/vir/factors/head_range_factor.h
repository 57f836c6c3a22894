#pragma once
/// A range that the oldest frame of the short window holds. Blocks of parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include <optional>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// WindowRangeFactor at frame 0 itself: antenna at p + Rz(yaw) R_O_0 (exp(-s) motion + lever).
/// Parameters: pose of frame 0 [7], node [5], anchor [4].
class HeadRangeFactor final : public ceres::SizedCostFunction<1, 7, 5, 4> {
 public:
  /// As WindowRangeFactor.
  HeadRangeFactor(const RangeTerm& range, const Vec3& motion_B, const Vec3& lever_B,
                  const std::optional<Quat>& q_O_B0 = std::nullopt)
      : range_(range), motion_B_(motion_B), offset_B_(motion_B + lever_B), q_O_B0_(q_O_B0) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm range_;
  Vec3 motion_B_, offset_B_;
  std::optional<Quat> q_O_B0_;
};

}  // namespace vir::factors
