#include "vir/ranging/range_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>

#include "vir/core/order_statistics.h"

namespace vir::ranging {
namespace {

constexpr int kPasses = 4;
constexpr std::size_t kStretches = 25;
/// A device's bias changes slowly with the distance: between stretches by so much, and so much more
/// per metre between them. What jumps is an obstacle that the robot passed behind [m], [m/m].
constexpr double kMostJump = 0.12, kMostSlope = 0.08;
/// A device that scatters more than this [m] about its curve is not told by one; nor is one from
/// which fewer of the ranges come.
constexpr double kMostSigma = 0.5, kFewestInliers = 0.5;
/// A series is set apart from the next by more than any gap within it.
constexpr TimeNs kApart = 1'000'000'000'000;

/// Mean of the shortest interval that holds half of the values: outliers may be many as long as
/// they scatter more than the rest.
double shorthMean(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = std::max<std::size_t>(1, (values.size() + 1) / 2);
  std::size_t best = 0;
  for (std::size_t i = 0; i + half <= values.size(); ++i) {
    if (values[i + half - 1] - values[i] < values[best + half - 1] - values[best]) best = i;
  }
  double sum = 0;
  for (std::size_t i = best; i < best + half; ++i) sum += values[i];
  return sum / static_cast<double>(half);
}

/// The most stretches that one slowly changing curve goes through; where there are several such
/// curves the lowest, since what is in the way makes ranges longer.
std::vector<RangeBiasModel::Node> smoothChain(const std::vector<RangeBiasModel::Node>& nodes) {
  const std::size_t n = nodes.size();
  std::vector<std::size_t> length(n, 1), from(n, n);
  std::vector<double> sum(n);
  std::size_t best = 0;
  const auto better = [&](std::size_t a, std::size_t b) {
    return length[a] > length[b] || (length[a] == length[b] && sum[a] < sum[b]);
  };
  for (std::size_t i = 0; i < n; ++i) {
    sum[i] = nodes[i].bias_m;
    for (std::size_t k = 0; k < i; ++k) {
      const double apart = nodes[i].distance_m - nodes[k].distance_m;
      const double step = std::abs(nodes[i].bias_m - nodes[k].bias_m);
      if (step > kMostJump + kMostSlope * apart) continue;
      const double through = sum[k] + nodes[i].bias_m;
      if (length[k] + 1 < length[i] || (length[k] + 1 == length[i] && through >= sum[i])) continue;
      length[i] = length[k] + 1;
      sum[i] = through;
      from[i] = k;
    }
    if (better(i, best)) best = i;
  }
  std::vector<RangeBiasModel::Node> out;
  for (std::size_t i = best; i < n; i = from[i]) out.push_back(nodes[i]);
  std::reverse(out.begin(), out.end());
  return out;
}

/// A first curve that outliers do not bend: robust means over stretches with as many samples each.
RangeBiasModel roughModel(const std::vector<CalibrationSample>& samples,
                          std::vector<std::size_t> order) {
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return samples[a].distance_m < samples[b].distance_m ||
           (samples[a].distance_m == samples[b].distance_m && a < b);
  });
  const std::size_t stretches = std::clamp<std::size_t>(order.size() / 20, 1, kStretches);
  std::vector<RangeBiasModel::Node> nodes;
  for (std::size_t k = 0; k < stretches; ++k) {
    std::vector<double> residuals, distances;
    for (std::size_t i = k * order.size() / stretches; i < (k + 1) * order.size() / stretches;
         ++i) {
      residuals.push_back(samples[order[i]].residual_m);
      distances.push_back(samples[order[i]].distance_m);
    }
    const double distance = std::max(0.0, median(distances));
    if (!nodes.empty() && distance <= nodes.back().distance_m) continue;
    nodes.push_back({distance, shorthMean(residuals), 0});
  }
  return RangeBiasModel(smoothChain(nodes));
}

/// Why the curve says nothing of the device; empty if it may be believed.
std::string problemOf(const RangeCalibration& fit, std::size_t samples) {
  char text[200];
  const double share = 1 - static_cast<double>(fit.too_long + fit.too_short) /
                               static_cast<double>(std::max<std::size_t>(1, samples));
  if (fit.sigma_m > kMostSigma) {
    std::snprintf(text, sizeof text,
                  "ranges scatter by %.2f m about the curve: is the anchor where it is said to be, "
                  "and its number right?",
                  fit.sigma_m);
    return text;
  }
  if (share < kFewestInliers) {
    std::snprintf(
        text, sizeof text,
        "only %.0f %% of the ranges lie about one curve: most came without a line of sight",
        100 * share);
    return text;
  }
  return {};
}

/// Marks samples too far from a curve; returns the scale of the others.
double markOutliers(const std::vector<CalibrationSample>& samples,
                    const std::function<double(double)>& curve, double limit,
                    RangeCalibration* out) {
  std::vector<double> off(samples.size());
  std::vector<double> rest;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    off[i] = samples[i].residual_m - curve(samples[i].distance_m);
    if (std::isfinite(off[i])) rest.push_back(std::abs(off[i]));
  }
  // Outliers widen even the median: cut them off and take it again.
  double scale = 0;
  for (int k = 0; k < 5; ++k) {
    scale = std::max(1.4826 * median(rest), 1e-4);
    rest.erase(
        std::remove_if(rest.begin(), rest.end(), [&](double r) { return r > limit * scale; }),
        rest.end());
  }
  out->too_long = out->too_short = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    out->outlier[i] = !(std::abs(off[i]) <= limit * scale);
    if (off[i] > limit * scale) ++out->too_long;
    if (off[i] < -limit * scale) ++out->too_short;
  }
  return scale;
}

GaussianProcess fitInliers(const std::vector<CalibrationSample>& samples,
                           const std::vector<char>& outlier, double correlation_factor) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (outlier[i]) continue;
    x.push_back(samples[i].distance_m);
    y.push_back(samples[i].residual_m);
  }
  GaussianProcessOptions options;
  options.correlation_factor = correlation_factor;
  return GaussianProcess(x, y, options);
}

RangeCorrelation correlationOf(const std::vector<CalibrationSample>& samples,
                               const std::vector<char>& outlier, const GaussianProcess& process) {
  std::map<int, std::vector<RangeResidual>> series;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (outlier[i]) continue;
    const double mean = process.predict(samples[i].distance_m).mean;
    series[samples[i].series].push_back(
        {samples[i].t, samples[i].residual_m - mean, process.hyper().noise});
  }
  std::vector<RangeResidual> all;
  TimeNs start = 0;
  for (auto& [id, list] : series) {
    std::stable_sort(list.begin(), list.end(),
                     [](const RangeResidual& a, const RangeResidual& b) { return a.t < b.t; });
    const TimeNs shift = start - list.front().t;
    for (RangeResidual r : list) {
      r.t += shift;
      all.push_back(r);
    }
    start = all.back().t + kApart;
  }
  return rangeCorrelation(all);
}

RangeBiasModel tableOf(const GaussianProcess& process, double step) {
  const double span = process.highest() - process.lowest();
  const int steps = std::clamp(static_cast<int>(std::ceil(span / std::max(step, 1e-3))), 1, 400);
  std::vector<RangeBiasModel::Node> nodes;
  for (int k = 0; k <= steps; ++k) {
    const double d = process.lowest() + span * k / steps;
    if (d < 0 || (!nodes.empty() && d <= nodes.back().distance_m)) continue;
    const auto p = process.predict(d);
    nodes.push_back({d, p.mean, p.sigma});
  }
  return RangeBiasModel(nodes, process.hyper().noise);
}

}  // namespace

RangeCalibration calibrateRangeBias(const std::vector<CalibrationSample>& samples,
                                    const RangeCalibrationOptions& options) {
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::isfinite(samples[i].distance_m) && std::isfinite(samples[i].residual_m)) {
      finite.push_back(i);
    }
  }
  if (static_cast<int>(finite.size()) < std::max(options.min_samples, 3)) {
    throw std::invalid_argument(
        "a bias model needs at least " + std::to_string(std::max(options.min_samples, 3)) +
        " ranges with a true distance, there are " + std::to_string(finite.size()));
  }
  RangeCalibration out;
  out.outlier.assign(samples.size(), 0);
  const RangeBiasModel rough = roughModel(samples, finite);
  markOutliers(
      samples, [&](double d) { return rough.at(d).mean_m; }, options.outlier_sigma, &out);
  std::optional<GaussianProcess> process;
  for (int pass = 0; pass < kPasses; ++pass) {
    process.emplace(fitInliers(samples, out.outlier, out.correlation.correlation_factor));
    const std::vector<char> before = out.outlier;
    out.correlation = correlationOf(samples, before, *process);
    out.sigma_m = markOutliers(
        samples, [&](double d) { return process->predict(d).mean; }, options.outlier_sigma, &out);
    if (pass > 0 && before == out.outlier) break;
  }
  out.hyper = process->hyper();
  out.sigma_m = out.hyper.noise;
  out.lowest_m = process->lowest();
  out.highest_m = process->highest();
  out.model = tableOf(*process, options.node_step_m);
  out.problem = problemOf(out, finite.size());
  return out;
}

}  // namespace vir::ranging
