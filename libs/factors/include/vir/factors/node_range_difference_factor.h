#pragma once
/// A difference of ranges to two anchors (TDoA) that a node of the long window holds. Blocks of
/// parameters: range_factor.h.
#include <ceres/sized_cost_function.h>

#include "vir/factors/range_factor.h"

namespace vir::factors {

/// |p_W_U - p_W_A1| + bias_1 - (|p_W_U - p_W_A0| + bias_0) - difference, with the antenna where
/// NodeRangeFactor has it. Whoever hears anchors that are synchronised measures such a difference
/// to a reference anchor 0, and no range. An obstacle before anchor 1 makes it longer, one before
/// the reference shorter: the loss is the same for both signs, that of ranges that are too short.
/// Parameters: node [5], reference anchor 0 [4], anchor 1 [4].
class NodeRangeDifferenceFactor final : public ceres::SizedCostFunction<1, 5, 4, 4> {
 public:
  /// `difference.range_m`: range to anchor 1 less range to anchor 0 [m]; vectors as
  /// NodeRangeFactor.
  NodeRangeDifferenceFactor(const RangeTerm& difference, const Vec3& motion_O, const Vec3& lever_O)
      : difference_(difference), motion_O_(motion_O), lever_O_(lever_O) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  RangeTerm difference_;
  Vec3 motion_O_, lever_O_;
};

}  // namespace vir::factors
