#include "vir/evaluation/association.h"

#include <algorithm>

#include "vir/core/order_statistics.h"
#include "vir/core/time_bounds.h"
#include "vir/geometry/interpolation.h"

namespace vir::evaluation {
namespace {

/// How much sparser a reference is before it is the one to take stamps from.
constexpr double kSparser = 1.5;

TimeNs medianStep(const Trajectory& trajectory) {
  std::vector<TimeNs> steps;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    steps.push_back(timeBetween(trajectory[i - 1].t, trajectory[i].t));
  }
  return medianInPlace(&steps);
}

/// Calls found(pose, T) for each pose of `wanted` with `dense` interpolated at its stamp.
template <typename Found>
void interpolateAt(const Trajectory& wanted, const Trajectory& dense, TimeNs max_gap,
                   Association* result, Found found) {
  auto next = dense.begin();  // first pose not before the stamp that is wanted
  for (const StampedPose& w : wanted) {
    next = std::lower_bound(next, dense.end(), w.t,
                            [](const StampedPose& d, TimeNs t) { return d.t < t; });
    if (next == dense.end()) {
      ++result->after;
    } else if (next->t == w.t) {
      found(w, next->T_W_B);
    } else if (next == dense.begin()) {
      ++result->before;
    } else if (const StampedPose& last = *(next - 1); timeBetween(last.t, next->t) > max_gap) {
      ++result->in_gap;
    } else {
      const double s = static_cast<double>(w.t - last.t) / static_cast<double>(next->t - last.t);
      found(w, interpolate(last.T_W_B, next->T_W_B, s));
    }
  }
}

}  // namespace

Association associate(const Trajectory& reference, const Trajectory& estimate,
                      const AssociationOptions& options) {
  Association result;
  if (reference.empty()) {
    result.before = static_cast<long>(estimate.size());
    return result;
  }
  const TimeNs duration = timeBetween(reference.front().t, reference.back().t);
  result.reference_s = toSeconds(duration);
  const TimeNs reference_step = medianStep(reference), step = medianStep(estimate);
  // Where it can be interpolated as it is, the reference stays what is interpolated.
  result.estimate_interpolated =
      step > 0 && reference_step > options.max_gap &&
      static_cast<double>(reference_step) > kSparser * static_cast<double>(step);
  TimeNs max_hole = options.max_hole;
  if (result.estimate_interpolated) {
    max_hole = std::max(max_hole, 2 * std::min(reference_step, kLatestStamp));
    interpolateAt(reference, estimate, options.max_gap, &result,
                  [&](const StampedPose& r, const Pose& e) {
                    result.pairs.push_back({r.t, r.T_W_B, e});
                  });
  } else {
    interpolateAt(estimate, reference, options.max_gap, &result,
                  [&](const StampedPose& e, const Pose& r) {
                    result.pairs.push_back({e.t, r, e.T_W_B});
                  });
  }
  TimeNs covered = 0;
  for (std::size_t i = 1; i < result.pairs.size(); ++i) {
    const TimeNs dt = timeBetween(result.pairs[i - 1].t, result.pairs[i].t);
    if (dt <= max_hole) covered += dt;
  }
  result.covered_s = toSeconds(covered);
  result.coverage = duration > 0 ? static_cast<double>(covered) / static_cast<double>(duration)
                                 : (result.pairs.empty() ? 0.0 : 1.0);
  return result;
}

}  // namespace vir::evaluation
