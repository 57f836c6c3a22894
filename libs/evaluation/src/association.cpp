#include "vir/evaluation/association.h"

#include <algorithm>

#include "vir/geometry/interpolation.h"

namespace vir::evaluation {

Association associate(const Trajectory& reference, const Trajectory& estimate,
                      const AssociationOptions& options) {
  Association result;
  if (reference.empty()) {
    result.before = static_cast<long>(estimate.size());
    return result;
  }
  const TimeNs duration = reference.back().t - reference.front().t;
  result.reference_s = toSeconds(duration);
  auto next = reference.begin();  // first pose of the reference not before the estimate's stamp
  for (const StampedPose& e : estimate) {
    next = std::lower_bound(next, reference.end(), e.t,
                            [](const StampedPose& r, TimeNs t) { return r.t < t; });
    if (next == reference.end()) {
      ++result.after;
    } else if (next->t == e.t) {
      result.pairs.push_back({e.t, next->T_W_B, e.T_W_B});
    } else if (next == reference.begin()) {
      ++result.before;
    } else if (const StampedPose& last = *(next - 1); next->t - last.t > options.max_gap) {
      ++result.in_gap;
    } else {
      const double s = static_cast<double>(e.t - last.t) / static_cast<double>(next->t - last.t);
      result.pairs.push_back({e.t, interpolate(last.T_W_B, next->T_W_B, s), e.T_W_B});
    }
  }
  TimeNs covered = 0;
  for (std::size_t i = 1; i < result.pairs.size(); ++i) {
    const TimeNs dt = result.pairs[i].t - result.pairs[i - 1].t;
    if (dt <= options.max_hole) covered += dt;
  }
  result.covered_s = toSeconds(covered);
  result.coverage = duration > 0 ? static_cast<double>(covered) / static_cast<double>(duration)
                                 : (result.pairs.empty() ? 0.0 : 1.0);
  return result;
}

}  // namespace vir::evaluation
