#include "vir/ranging/range_correlation.h"

#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"

namespace vir::ranging {
namespace {

/// Ranges a mean is taken of, at least.
constexpr double kFewestForMean = 10;

struct Whitened {
  TimeNs t;
  double w;
};

std::vector<Whitened> whiten(const std::vector<RangeResidual>& residuals, double clip_sigma) {
  std::vector<Whitened> series;
  std::vector<double> sizes;
  for (const RangeResidual& r : residuals) {
    const double w = r.residual_m / r.sigma_m;
    if (!(r.sigma_m > 0) || !std::isfinite(w)) continue;
    series.push_back({r.t, w});
    sizes.push_back(std::abs(w));
  }
  const double limit = clip_sigma * 1.4826 * median(sizes);
  if (limit > 0) {
    for (Whitened& s : series) s.w = std::clamp(s.w, -limit, limit);
  }
  return series;
}

/// Autocorrelation at `lag`, over pairs that are not torn apart by a gap.
double autocorrelation(const std::vector<Whitened>& series, std::size_t lag, double max_interval_s,
                       int* pairs) {
  double product = 0, square = 0;
  *pairs = 0;
  for (std::size_t i = lag; i < series.size(); ++i) {
    const double interval = toSeconds(series[i].t - series[i - lag].t);
    if (interval > static_cast<double>(lag) * max_interval_s) continue;
    const double a = series[i - lag].w, b = series[i].w;
    product += a * b;
    square += 0.5 * (a * a + b * b);
    ++*pairs;
  }
  return square > 0 ? product / square : 0;
}

}  // namespace

RangeCorrelation rangeCorrelation(const std::vector<RangeResidual>& residuals,
                                  const RangeCorrelationOptions& options) {
  RangeCorrelation result;
  const std::vector<Whitened> series = whiten(residuals, options.clip_sigma);
  std::vector<double> intervals;
  double square = 0;
  for (std::size_t i = 0; i < series.size(); ++i) {
    square += series[i].w * series[i].w;
    if (i > 0) intervals.push_back(toSeconds(series[i].t - series[i - 1].t));
  }
  const double longest = options.max_gap * median(intervals);
  const double one = autocorrelation(series, 1, longest, &result.pairs);
  if (result.pairs < options.min_pairs) return result;

  result.rms_ratio = std::sqrt(square / static_cast<double>(series.size()));
  const double noise = 2 / std::sqrt(static_cast<double>(result.pairs));
  if (one > noise) {
    result.lag_one = one;
    int pairs = 0;
    const double two = autocorrelation(series, 2, longest, &pairs);
    // share * decay and share * decay^2 of an AR(1) error under white noise; without white noise
    // the share is 1.
    const double decay = std::clamp(two > noise ? two / one : 0.0, one, 0.99);
    result.correlation_factor =
        std::clamp(1 + 2 * one / std::max(1 - decay, 1e-3), 1.0, options.max_factor);
  }
  result.variance_factor =
      std::clamp(result.correlation_factor * std::max(1.0, result.rms_ratio * result.rms_ratio),
                 1.0, options.max_total_factor);
  return result;
}

std::vector<RangeResidual> withoutSlowPart(std::vector<RangeResidual> residuals, double span_s) {
  std::stable_sort(residuals.begin(), residuals.end(),
                   [](const RangeResidual& a, const RangeResidual& b) { return a.t < b.t; });
  const TimeNs half = fromSeconds(span_s / 2);
  std::vector<RangeResidual> out;
  out.reserve(residuals.size());
  std::size_t first = 0, last = 0;  // [first, last) lies within `half` of the present one
  double sum = 0;
  for (const RangeResidual& r : residuals) {
    while (last < residuals.size() && residuals[last].t <= r.t + half) {
      sum += residuals[last++].residual_m;
    }
    while (residuals[first].t < r.t - half) sum -= residuals[first++].residual_m;
    const double n = static_cast<double>(last - first);
    if (n < kFewestForMean) continue;
    RangeResidual high = r;
    high.residual_m = (r.residual_m - sum / n) * std::sqrt(n / (n - 1));
    out.push_back(high);
  }
  return out;
}

}  // namespace vir::ranging
