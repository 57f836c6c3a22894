#include "output/calibration_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace vir::app {
namespace {

constexpr std::size_t kMostPoints = 4000;  // in the picture
constexpr double kShownSigma = 10;         // outliers farther away would squeeze the picture
const evaluation::Color kRange{150, 160, 170}, kOutlier{214, 110, 90}, kMean{20, 60, 130};
const evaluation::Color kMeanBand{160, 190, 230}, kRangeBand{228, 236, 246};

/// About six round distances over the data.
std::vector<double> tableDistances(const ranging::RangeCalibration& fit) {
  std::vector<double> out = evaluation::axisTicks(fit.lowest_m, fit.highest_m, 6);
  if (out.empty()) out.push_back(0.5 * (fit.lowest_m + fit.highest_m));
  return out;
}

struct AnchorMean {
  long count = 0;
  double sum = 0;
};

/// Mean residual from the model per anchor, without outliers.
std::map<int, AnchorMean> anchorMeans(const UwbSamples& data,
                                      const ranging::RangeCalibration& fit) {
  std::map<int, AnchorMean> means;
  for (std::size_t i = 0; i < data.samples.size(); ++i) {
    if (fit.outlier[i]) continue;
    AnchorMean& m = means[data.anchor[i]];
    ++m.count;
    m.sum += data.samples[i].residual_m - fit.model.at(data.samples[i].distance_m).mean_m;
  }
  return means;
}

long unknownAnchors(const UwbSamples& data) {
  long sum = 0;
  for (const auto& item : data.unknown_anchor) sum += item.second;
  return sum;
}

void addPoints(const UwbSamples& data, const ranging::RangeCalibration& fit, bool outliers,
               evaluation::Panel* panel) {
  const evaluation::Color color = outliers ? kOutlier : kRange;
  std::vector<Vec2> all;
  for (std::size_t i = 0; i < data.samples.size(); ++i) {
    const ranging::CalibrationSample& s = data.samples[i];
    if (static_cast<bool>(fit.outlier[i]) != outliers) continue;
    const double off = std::abs(s.residual_m - fit.model.at(s.distance_m).mean_m);
    if (!(off < kShownSigma * fit.sigma_m)) continue;
    all.push_back({s.distance_m, 1000 * s.residual_m});
  }
  const std::size_t shown = std::min(all.size(), kMostPoints);
  for (std::size_t k = 0; k < shown; ++k) {
    panel->marks.push_back(
        {all[k * all.size() / shown], color, 1.5, evaluation::Mark::Shape::dot, ""});
  }
}

/// The area between two curves over the same abscissae.
evaluation::Area between(std::vector<Vec2> upper, const std::vector<Vec2>& lower,
                         evaluation::Color color) {
  upper.insert(upper.end(), lower.rbegin(), lower.rend());
  return {color, 1, upper};
}

}  // namespace

std::vector<TableRow> calibrationTable(const UwbSamples& data,
                                       const ranging::RangeCalibration& fit) {
  const auto count = [](long n) { return std::to_string(n); };
  std::vector<TableRow> rows = {{"ranges read", count(data.ranges), ""}};
  if (data.checks.rejected() > 0) {
    rows.push_back({"left out: " + data.checks.text(), count(data.checks.rejected()), ""});
  }
  if (unknownAnchors(data) > 0) {
    rows.push_back({"left out: anchor without a position", count(unknownAnchors(data)), ""});
  }
  if (data.without_truth > 0) {
    rows.push_back({"left out: no ground truth then", count(data.without_truth), ""});
  }
  const long used = static_cast<long>(data.samples.size()) - fit.too_long - fit.too_short;
  rows.push_back({"outliers too long (no line of sight)", count(fit.too_long), ""});
  rows.push_back({"outliers too short", count(fit.too_short), ""});
  rows.push_back({"ranges used", count(used), ""});
  rows.push_back({"sigma of a range", fixed(fit.sigma_m, 4), "m"});
  rows.push_back({"correlation from one range to the next", fixed(fit.correlation.lag_one, 2), ""});
  rows.push_back({"sigma as if independent",
                  fixed(fit.sigma_m * std::sqrt(fit.correlation.variance_factor), 4), "m"});
  rows.push_back({"distances", fixed(fit.lowest_m, 2) + " to " + fixed(fit.highest_m, 2), "m"});
  if (fit.hyper.signal > 1e-3) {  // below a millimetre the bias does not change with distance
    rows.push_back({"length scale of the bias", fixed(fit.hyper.length, 2), "m"});
  }
  for (const double d : tableDistances(fit)) {
    const ranging::RangeBiasModel::Bias b = fit.model.at(d);
    rows.push_back(
        {"bias at " + fixed(d, 2) + " m", fixed(b.mean_m, 4) + " +- " + fixed(b.sigma_m, 4), "m"});
  }
  const auto means = anchorMeans(data, fit);
  for (const auto& [id, m] : means) {
    if (means.size() < 2) break;
    rows.push_back({"anchor " + std::to_string(id) + " beyond that (" + count(m.count) + " ranges)",
                    fixed(m.sum / static_cast<double>(m.count), 4), "m"});
  }
  return rows;
}

nlohmann::json calibrationJson(const UwbSamples& data, const ranging::RangeCalibration& fit) {
  nlohmann::json j;
  j["ranges"] = data.ranges;
  j["left_out"] = {{"without_truth", data.without_truth},
                   {"anchor_without_position", unknownAnchors(data)}};
  for (const auto& [problem, count] : data.checks.problems) j["left_out"][name(problem)] = count;
  j["used"] = static_cast<long>(data.samples.size()) - fit.too_long - fit.too_short;
  j["outliers"] = {{"too_long", fit.too_long}, {"too_short", fit.too_short}};
  j["sigma_m"] = fit.sigma_m;
  j["correlation"] = {{"lag_one", fit.correlation.lag_one},
                      {"variance_factor", fit.correlation.variance_factor}};
  j["distance_m"] = {{"min", fit.lowest_m}, {"max", fit.highest_m}};
  j["hyper_parameters"] = {{"mean_m", fit.hyper.mean},
                           {"signal_m", fit.hyper.signal},
                           {"length_m", fit.hyper.length},
                           {"noise_m", fit.hyper.noise},
                           {"log_likelihood", fit.hyper.log_likelihood}};
  for (const auto& [id, m] : anchorMeans(data, fit)) {
    j["anchors"][std::to_string(id)] = {{"ranges", m.count},
                                        {"mean_residual_m", m.sum / static_cast<double>(m.count)}};
  }
  for (const auto& n : fit.model.nodes()) {
    j["model"].push_back(
        {{"distance_m", n.distance_m}, {"bias_m", n.bias_m}, {"sigma_m", n.sigma_m}});
  }
  return j;
}

evaluation::Figure calibrationFigure(const UwbSamples& data, const ranging::RangeCalibration& fit) {
  evaluation::Figure figure;
  figure.width = 900;
  figure.height = 560;
  figure.title = "Range bias over distance";
  evaluation::Panel panel;
  panel.corner = {90, 100};
  panel.size = {780, 390};
  panel.x_label = "true distance [m]";
  panel.y_label = "measured - true [mm]";
  std::vector<Vec2> mean_upper, mean_lower, range_upper, range_lower;
  evaluation::Curve mean;
  mean.color = kMean;
  mean.width = 2;
  mean.strokes.emplace_back();
  for (int k = 0; k <= 300; ++k) {
    const double d = fit.lowest_m + (fit.highest_m - fit.lowest_m) * k / 300;
    const ranging::RangeBiasModel::Bias b = fit.model.at(d);
    const double m = 1000 * b.mean_m, s = 2000 * b.sigma_m;
    const double r = 2000 * std::hypot(b.sigma_m, fit.sigma_m);
    mean.strokes[0].push_back({d, m});
    mean_upper.push_back({d, m + s});
    mean_lower.push_back({d, m - s});
    range_upper.push_back({d, m + r});
    range_lower.push_back({d, m - r});
  }
  panel.areas = {between(range_upper, range_lower, kRangeBand),
                 between(mean_upper, mean_lower, kMeanBand)};
  panel.extent = range_upper;
  panel.extent.insert(panel.extent.end(), range_lower.begin(), range_lower.end());
  addPoints(data, fit, false, &panel);
  addPoints(data, fit, true, &panel);
  // The band of the mean again as lines: points cover it.
  evaluation::Curve upper, lower;
  upper.color = lower.color = kMean;
  upper.width = lower.width = 0.8;
  upper.strokes = {mean_upper};
  lower.strokes = {mean_lower};
  panel.curves = {mean, upper, lower};
  const long used = static_cast<long>(data.samples.size()) - fit.too_long - fit.too_short;
  figure.subtitle = std::to_string(used) + " ranges, sigma " + fixed(1000 * fit.sigma_m, 1) +
                    " mm; " + std::to_string(fit.too_long + fit.too_short) + " outliers (beyond " +
                    fixed(kShownSigma, 0) + " sigma not shown)";
  figure.legend = {640, 16};
  figure.entries = {{"mean and its 2 sigma", kMean},
                    {"2 sigma of a range", kMeanBand},
                    {"ranges", kRange},
                    {"outliers", kOutlier}};
  figure.entries[1].color = kRangeBand;
  figure.panels.push_back(panel);
  return figure;
}

}  // namespace vir::app
