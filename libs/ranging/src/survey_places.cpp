#include "survey_places.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "anchor_starts.h"
#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/ranging/range_correlation.h"

namespace vir::ranging {
namespace {

/// Turns of the survey that are tried, and ranges of each anchor for the first look and the last.
constexpr int kTurns = 16;
constexpr std::size_t kCoarse = 16, kFull = 150, kStartsPerTurn = 3, kFollowed = 6;
/// An optimum so much worse on the few ranges looked at first is not followed up.
constexpr double kHopeless = 60;
/// Two solutions are one within so many sigmas (squared), or so near [m], [rad].
constexpr double kSame = 9, kSameM = 0.05, kSameRad = 0.01;
/// Fewer ranges of an anchor do not tell whether it fits; share that has to, and how much larger
/// than claimed the residuals of a survey that fits may be.
constexpr int kFewest = 8;
/// Ranges from where the path may have drifted by so much since [m] say nothing, if there are so
/// many newer ones.
constexpr double kMostDrift = 0.3;
constexpr std::size_t kEnough = 200;
constexpr double kShare = 0.5, kWorstScale = 4;

/// Seen with the survey turned by `yaw`, all ranges are to one point: where the path's end is.
std::vector<Vec3> endsAt(double yaw, const SurveyData& data,
                         const std::vector<SurveyedAnchor>& survey,
                         const SurveyMatchOptions& options) {
  FitData one;
  const Mat3 R = rotZ(yaw);
  for (const SurveyRange& r : data.ranges) {
    one.p.push_back(survey[r.anchor].p_S - R * (r.p_W - data.end_W));
    one.z.push_back(r.range_m);
    one.sigma.push_back(r.sigma_m);
    one.drift.push_back(0);
  }
  AnchorInitOptions o;
  o.bias_sigma_m = options.bias_sigma_m;
  o.robust = options.robust;
  const RangeFit fit(&one, &o, std::nullopt);
  std::vector<Vec3> out;
  for (const FitState& s : startPositions(fit, pathShape(one.p), kStartsPerTurn)) {
    out.push_back(s.a);
  }
  return out;
}

double wrapped(double angle) { return std::remainder(angle, 2 * kPi); }

bool same(const SurveyFitter& fitter, const SurveyState& a, const SurveyState& b) {
  Eigen::Vector4d d;
  d << wrapped(b.yaw - a.yaw), b.end_S - a.end_S;
  if (std::abs(d[0]) < kSameRad && d.tail<3>().norm() < kSameM) return true;
  return d.dot(fitter.covariance(a).inverse() * d) < kSame;
}

std::vector<SurveyOptimum> refined(const std::vector<SurveyState>& starts,
                                   const SurveyFitter& fitter, int iterations) {
  std::vector<SurveyOptimum> all, out;
  for (const SurveyState& start : starts) {
    SurveyOptimum o;
    o.x = fitter.minimise(start, iterations, &o.cost);
    if (std::isfinite(o.cost) && o.x.end_S.allFinite()) all.push_back(o);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const SurveyOptimum& a, const SurveyOptimum& b) { return a.cost < b.cost; });
  for (const SurveyOptimum& o : all) {
    if (out.size() >= kFollowed || o.cost > all.front().cost + kHopeless) break;
    const bool known = std::any_of(out.begin(), out.end(),
                                   [&](const SurveyOptimum& k) { return same(fitter, k.x, o.x); });
    if (!known) out.push_back(o);
  }
  return out;
}

std::vector<SurveyState> statesOf(const std::vector<SurveyOptimum>& optima) {
  std::vector<SurveyState> out;
  for (const SurveyOptimum& o : optima) out.push_back(o.x);
  return out;
}

double worthOf(const SurveyData& data, const std::vector<double>& residuals, double scale) {
  std::vector<RangeResidual> series;
  std::vector<TimeNs> next;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const std::size_t a = data.ranges[i].anchor;
    if (next.size() <= a) next.resize(a + 1, 0);
    const TimeNs t = (static_cast<TimeNs>(a) << 40) + next[a]++ * 1'000'000;
    if (std::abs(residuals[i]) > kInlierSigma * scale) continue;
    series.push_back({t, residuals[i] / scale, 1.0});
  }
  std::stable_sort(series.begin(), series.end(),
                   [](const RangeResidual& a, const RangeResidual& b) { return a.t < b.t; });
  return rangeCorrelation(series).correlation_factor;
}

bool explainsAll(const SurveyData& data, const std::vector<double>& residuals, double scale,
                 std::size_t anchors) {
  if (scale > kWorstScale) return false;
  std::vector<int> all(anchors, 0), fit(anchors, 0);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    ++all[data.ranges[i].anchor];
    fit[data.ranges[i].anchor] += std::abs(residuals[i]) < kInlierSigma * std::min(scale, 2.0);
  }
  for (std::size_t a = 0; a < anchors; ++a) {
    if (all[a] >= kFewest && fit[a] < kShare * all[a]) return false;
  }
  return true;
}

double spreadOfBiases(const SurveyState& x, const std::vector<char>& heard) {
  std::vector<double> biases;
  for (std::size_t a = 0; a < heard.size(); ++a) {
    if (heard[a]) biases.push_back(x.anchors[a][3]);
  }
  const double middle = median(biases);
  double most = 0;
  for (const double b : biases) most = std::max(most, std::abs(b - middle));
  return most;
}

}  // namespace

SurveyData surveyData(const std::vector<SurveyRange>& ranges, std::size_t anchors,
                      double drift_ratio) {
  SurveyData data;
  double travelled = 0;
  const Vec3* newer = nullptr;
  for (auto r = ranges.rbegin(); r != ranges.rend(); ++r) {
    const bool valid = r->anchor < anchors && r->p_W.allFinite() && r->p_W.norm() < 1e7 &&
                       r->range_m > 0 && r->range_m < 1e5 && r->sigma_m > 0 &&
                       std::isfinite(r->sigma_m);
    if (!valid) continue;
    if (data.ranges.size() >= kEnough && drift_ratio * travelled > kMostDrift) break;
    if (newer) travelled += (*newer - r->p_W).norm();
    newer = &r->p_W;
    data.ranges.push_back(*r);
    data.drift.push_back(drift_ratio * travelled);
    data.ranges.back().sigma_m = std::hypot(r->sigma_m, data.drift.back());
  }
  std::reverse(data.ranges.begin(), data.ranges.end());
  std::reverse(data.drift.begin(), data.drift.end());
  if (!data.ranges.empty()) data.end_W = data.ranges.back().p_W;
  return data;
}

SurveyData without(const SurveyData& data, std::size_t anchor) {
  SurveyData out;
  out.end_W = data.end_W;
  for (std::size_t i = 0; i < data.ranges.size(); ++i) {
    if (data.ranges[i].anchor == anchor) continue;
    out.ranges.push_back(data.ranges[i]);
    out.drift.push_back(data.drift[i]);
  }
  return out;
}

std::vector<char> heardIn(const SurveyData& data, std::size_t anchors) {
  std::vector<char> heard(anchors, 0);
  for (const SurveyRange& r : data.ranges) heard[r.anchor] = 1;
  return heard;
}

SurveyPlaces placesOf(const SurveyData& data, const std::vector<SurveyedAnchor>& survey,
                      const SurveyMatchOptions& options) {
  SurveyPlaces out;
  const SurveyData coarse_data = data.thinned(kCoarse), full_data = data.thinned(kFull);
  if (coarse_data.ranges.empty()) return out;
  const SurveyFitter coarse(&coarse_data, &survey, &options);
  SurveyFitter full(&full_data, &survey, &options);
  std::vector<SurveyState> starts;
  for (int k = 0; k < kTurns; ++k) {
    const double yaw = wrapped(2 * kPi * k / kTurns);
    for (const Vec3& end : endsAt(yaw, coarse_data, survey, options)) {
      starts.push_back(coarse.startAt(yaw, end));
    }
  }
  const std::vector<SurveyOptimum> first = refined(starts, coarse, 12);
  std::vector<SurveyOptimum> optima = refined(statesOf(first), full, 30);
  if (optima.empty()) return out;
  out.raw_cost = optima.front().cost;
  out.ranges = full_data.ranges.size();
  const std::vector<double> r = full.residuals(optima.front().x);
  out.scale = robustScale(r);
  if (options.correlation) out.worth = worthOf(full_data, r, out.scale);
  out.consistent = explainsAll(full_data, r, out.scale, survey.size());
  full.setFactors(out.scale, out.worth);
  optima = refined(statesOf(optima), full, 30);
  for (SurveyOptimum& o : optima) {
    o.x.yaw = wrapped(o.x.yaw);
    if (2 * (o.cost - optima.front().cost) <= options.mirror_chi2) out.optima.push_back(o);
  }
  if (optima.empty()) return out;
  out.bias_spread_m = spreadOfBiases(optima.front().x, heardIn(data, survey.size()));
  return out;
}

LevelTransform transformOf(const SurveyData& data, const SurveyState& x) {
  return {x.yaw, x.end_S - rotZ(x.yaw) * data.end_W};
}

}  // namespace vir::ranging
