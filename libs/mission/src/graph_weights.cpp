#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "graph_state.h"

namespace vir::mission {
namespace {

/// Steps of the search, and how far it goes.
constexpr double kStep = 4, kLeast = 1e-4, kMost = 300;
/// Where the odometry itself says how far steps may be off, they are not off by more: loops that
/// share an error agree with each other, and would be trusted for that.
constexpr double kMostOfOdometry = 1;
constexpr int kStepsAtOnce = 8;
/// That the two state their variances rightly counts as so many numbers that were seen.
constexpr double kBelievedAsStated = 8;
constexpr int kIterations = 2;
/// Where loops say little the path is left alone: a factor of e in its variances must gain so much.
constexpr double kLeftAlone = 4;

}  // namespace

/// Variance components: what estimator and loops state of their errors is right up to a factor
/// each. The calibration's errors are in all loops alike, and what the lens does not explain makes
/// them contradict each other; a path may be far better or worse than its covariance. Of the two
/// factors only the ratio moves the solution; the other is taken where it is likeliest.
double MissionGraph::Impl::evidence() {
  const double squared = minimise(kIterations);
  const auto H = factorOf(scale);
  if (squared < 0 || !H || !(H->vectorD().minCoeff() > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  // Edges and ties of a keyframe are one statement of four numbers.
  double scaled = 0, seen = 0;
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    if (nodes[i].fixed || nodes[i - 1].fixed || nodes[i].stretch != nodes[i - 1].stretch) continue;
    scaled += 4;
  }
  for (const double w : weights) seen += w > 0 ? 4 : 0;
  const double numbers = seen + kBelievedAsStated;
  return numbers * std::log((squared + kBelievedAsStated) / numbers) +
         (scaled + kLeftAlone) * std::log(scale) + H->vectorD().array().log().sum();
}

void MissionGraph::Impl::weigh() {
  if (std::none_of(weights.begin(), weights.end(), [](double w) { return w > 0; })) return;
  double least = evidence();
  if (!std::isfinite(least)) return;
  const double begin = scale, most = odometry_taken ? kMostOfOdometry : kMost;
  for (const double step : {kStep, 1 / kStep}) {
    for (int i = 0; i < kStepsAtOnce; ++i) {
      const double before = scale;
      scale = std::clamp(scale * step, kLeast, most);
      const double here = scale == before ? least : evidence();
      if (!(here < least)) {
        scale = before;
        break;
      }
      least = here;
    }
    if (scale != begin) break;
  }
  minimise(options.iterations);
}

}  // namespace vir::mission
