#include <algorithm>
#include <cmath>

#include "csv_text.h"
#include "run_figures.h"
#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/evaluation/figure_parts.h"

namespace vir::results {
namespace {

const evaluation::Color kBand{130, 130, 130};
constexpr std::size_t kMaxPanels = 4;
constexpr std::size_t kMaxPoints = 3000;        // of a curve: more cannot be seen
constexpr std::size_t kMaxCalibrations = 1000;  // of each of sixteen outlines
constexpr double kLeft = 80, kWidth = 1090;

double seconds(const RunPictures& run, TimeNs t) { return toSeconds(t - run.first_frame); }

evaluation::Figure emptyFigure(const char* title, const char* subtitle) {
  evaluation::Figure figure;
  figure.width = 1200;
  figure.title = title;
  figure.subtitle = subtitle;
  figure.legend = {20, 64};
  return figure;
}

/// Puts the panel below what is there.
void append(evaluation::Panel panel, double height, evaluation::Figure* figure) {
  if (figure->panels.empty()) {
    figure->height = 64 + 20 * static_cast<double>(figure->entries.size());
  }
  panel.corner = {kLeft, figure->height + 40};
  panel.size = {kWidth, height};
  panel.x_label = "time since the first frame [s]";
  figure->height = panel.corner.y() + height + 48;
  figure->panels.push_back(std::move(panel));
}

/// At most kMaxPoints of a stroke: of those that fall together the highest.
std::vector<Vec2> limited(const std::vector<Vec2>& stroke) {
  const std::size_t bucket = (stroke.size() + kMaxPoints - 1) / kMaxPoints;
  if (bucket < 2) return stroke;
  std::vector<Vec2> out;
  for (std::size_t i = 0; i < stroke.size(); i += bucket) {
    const auto end =
        stroke.begin() + static_cast<std::ptrdiff_t>(std::min(i + bucket, stroke.size()));
    out.push_back(*std::max_element(stroke.begin() + static_cast<std::ptrdiff_t>(i), end,
                                    [](const Vec2& a, const Vec2& b) { return a.y() < b.y(); }));
  }
  return out;
}

/// Band between +half and low * half of each point (x, half), cut where `half` is unknown (0) or
/// the points are more than `hole` seconds apart.
void addBand(const std::vector<Vec2>& points, double low, double hole, evaluation::Panel* panel) {
  std::vector<Vec2> run;
  const auto close = [&] {
    if (run.size() > 1) {
      std::vector<Vec2> outline = run;
      for (auto p = run.rbegin(); p != run.rend(); ++p) outline.emplace_back(p->x(), low * p->y());
      panel->areas.push_back({kBand, 0.25, outline});
    }
    run.clear();
  };
  for (const Vec2& p : points) {
    const bool usable = p.allFinite() && p.y() > 0;
    if (!usable || (!run.empty() && p.x() - run.back().x() > hole)) close();
    if (usable) run.push_back(p);
  }
  close();
}

double quantile(std::vector<double> values, double share) {
  return quantileInPlace(&values, share);
}

/// Colour of each decision: accepted first.
std::map<RangeDecision, evaluation::Color> decisionColors(const std::vector<RangeRecord>& ranges) {
  static constexpr std::size_t kOthers[] = {1, 4, 3, 5, 2};
  std::map<RangeDecision, evaluation::Color> colors;
  for (const RangeRecord& r : ranges) colors.emplace(r.decision, evaluation::Color());
  std::size_t i = 0;
  for (auto& [decision, color] : colors) {
    color = decision == RangeDecision::accepted
                ? evaluation::figureColor(0)
                : evaluation::figureColor(kOthers[i++ % std::size(kOthers)]);
  }
  return colors;
}

bool hasResidual(const RangeRecord& r) {
  return (r.sigma_m > 0 || r.predicted_m != 0) && std::isfinite(r.residual_m) &&
         std::isfinite(r.sigma_m);
}

/// The ranges with a residual, by anchor; the anchors with the most of them first.
std::vector<std::vector<RangeRecord>> byAnchor(const std::vector<RangeRecord>& ranges) {
  std::map<std::uint64_t, std::vector<RangeRecord>> groups;
  for (const RangeRecord& r : ranges) {
    if (hasResidual(r)) groups[r.anchor].push_back(r);
  }
  std::vector<std::vector<RangeRecord>> out;
  for (auto& [id, group] : groups) out.push_back(std::move(group));
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return out;
}

evaluation::Panel residualPanel(const RunPictures& run, const std::vector<RangeRecord>& ranges,
                                const std::map<RangeDecision, evaluation::Color>& colors) {
  evaluation::Panel panel;
  panel.y_label = "residual [m]";
  std::vector<double> sizes, sigmas;
  std::vector<Vec2> band;
  for (const RangeRecord& r : ranges) {
    sizes.push_back(std::abs(r.residual_m));
    sigmas.push_back(r.sigma_m);
    band.emplace_back(seconds(run, r.t), 2 * r.sigma_m);
  }
  // A few gross errors must not squash the rest: they are drawn at the edge.
  const double sigma = std::max(quantile(sigmas, 0.5), 1e-3);
  const double edge = std::clamp(1.5 * quantile(sizes, 0.97), 3 * sigma, 10 * sigma);
  const double hole = std::max(2.0, 0.02 * (band.back().x() - band.front().x()));
  addBand(band, -1, hole, &panel);
  long beyond = 0;
  for (const RangeRecord& r : ranges) {
    const bool outside = std::abs(r.residual_m) > edge;
    beyond += outside ? 1 : 0;
    const Vec2 at(seconds(run, r.t), std::clamp(r.residual_m, -edge, edge));
    panel.marks.push_back({at, colors.at(r.decision), outside ? 2.6 : 1.7,
                           outside ? evaluation::Mark::Shape::ring : evaluation::Mark::Shape::dot,
                           ""});
  }
  panel.extent = {{band.front().x(), -edge}, {band.back().x(), edge}};
  panel.title = "Anchor " + std::to_string(ranges.front().anchor);
  if (beyond > 0) panel.title += csv::format(": %ld beyond the edge (rings)", beyond);
  return panel;
}

/// `value(point)`: what is drawn, and its standard deviation. Points that are not finite are left
/// out.
template <typename Value>
void addCalibrationCurve(const RunPictures& run, TimeNs hole, evaluation::Color color, Value value,
                         evaluation::Panel* panel) {
  std::vector<TimeNs> stamps;
  std::vector<Vec2> values, middle;  // (value, sigma); (time, value)
  const std::size_t step = run.calibrations.size() / kMaxCalibrations + 1;
  for (std::size_t i = 0; i < run.calibrations.size(); i += step) {
    const Vec2 v = value(run.calibrations[i]);
    if (!v.allFinite()) continue;
    stamps.push_back(run.calibrations[i].t);
    values.push_back(v);
    middle.emplace_back(seconds(run, stamps.back()), v.x());
  }
  evaluation::Curve curve{color, 1.5, {}};
  const auto stamp = [&](std::size_t i) { return stamps[i]; };
  const TimeNs widened = hole * static_cast<TimeNs>(step);
  curve.strokes = evaluation::cutAtHoles(middle.size(), widened, stamp,
                                         [&](std::size_t i) { return middle[i]; });
  for (const auto& band : evaluation::cutAtHoles(middle.size(), widened, stamp, [&](std::size_t i) {
         return Vec2(static_cast<double>(i), 0.0);
       })) {
    std::vector<Vec2> outline;
    for (const Vec2& at : band) {
      const auto i = static_cast<std::size_t>(at.x());
      outline.emplace_back(middle[i].x(), values[i].x() + values[i].y());
    }
    for (auto at = band.rbegin(); at != band.rend(); ++at) {
      const auto i = static_cast<std::size_t>(at->x());
      outline.emplace_back(middle[i].x(), values[i].x() - values[i].y());
    }
    panel->areas.push_back({color, 0.15, outline});
  }
  panel->curves.push_back(curve);
  if (middle.empty()) return;
  // Room for the band at its end, where it is narrow.
  for (const double side : {-1.0, 1.0}) {
    panel->extent.emplace_back(middle.back().x(), values.back().x() + side * values.back().y());
  }
}

}  // namespace

evaluation::Figure rangesFigure(const RunPictures& run) {
  evaluation::Figure figure = emptyFigure("Range residuals",
                                          "measured less predicted, bias included, when the "
                                          "range was processed");
  const auto groups = byAnchor(run.ranges);
  const auto colors = decisionColors(run.ranges);
  for (const auto& [decision, color] : colors) {
    const auto shown = [&d = decision](const RangeRecord& r) {
      return r.decision == d && hasResidual(r);
    };
    if (std::any_of(run.ranges.begin(), run.ranges.end(), shown)) {
      figure.entries.push_back({name(decision), color});
    }
  }
  figure.entries.push_back({"+-2 sigma of prediction and range together", kBand});
  if (groups.size() > kMaxPanels) {
    figure.subtitle +=
        "; " + std::to_string(groups.size() - kMaxPanels) + " more anchors not shown";
  }
  for (std::size_t i = 0; i < std::min(groups.size(), kMaxPanels); ++i) {
    append(residualPanel(run, groups[i], colors), 200, &figure);
  }
  return figure;
}

evaluation::Figure errorFigure(const RunPictures& run) {
  evaluation::Figure figure = emptyFigure("Position error",
                                          "of the causal trajectory against the ground truth, "
                                          "position and yaw aligned");
  if (!run.evaluation) return figure;
  const auto& pairs = run.evaluation->association.pairs;
  const auto& errors = run.evaluation->position_error_m;
  figure.entries = {{"error", evaluation::figureColor(0)}};
  evaluation::Panel panel;
  panel.y_label = "error [m]";
  panel.from_zero = true;
  evaluation::Curve curve{evaluation::figureColor(0), 1.5, {}};
  const auto stamp = [&](std::size_t i) { return pairs[i].t; };
  for (const auto& stroke : evaluation::cutAtHoles(
           pairs.size(), evaluation::holeOf(run.causal), stamp,
           [&](std::size_t i) { return Vec2(seconds(run, stamp(i)), errors[i]); })) {
    curve.strokes.push_back(limited(stroke));
  }
  panel.curves.push_back(curve);
  std::vector<Vec2> band;
  double highest = 0, largest = 0;
  for (const double e : errors) largest = std::max(largest, e);
  for (std::size_t i = 0; i < run.causal.size() && i < run.position_sigma_m.size(); ++i) {
    band.emplace_back(seconds(run, run.causal[i].t), 3 * run.position_sigma_m[i]);
    if (std::isfinite(band.back().y())) highest = std::max(highest, band.back().y());
  }
  if (highest > 0) {
    figure.entries.push_back({"3 standard deviations by the estimator's own covariance", kBand});
  }
  addBand(limited(band), 0, toSeconds(evaluation::holeOf(run.causal)) * 3, &panel);
  if (!errors.empty()) {
    panel.extent = {{seconds(run, pairs.front().t), std::min(highest, 3 * largest)}};
  }
  append(std::move(panel), 200, &figure);
  return figure;
}

evaluation::Figure calibrationFigure(const RunPictures& run) {
  evaluation::Figure figure = emptyFigure(
      "Calibration over time", "less what was given, within one standard deviation (shaded)");
  if (run.calibrations.size() < 2) return figure;
  const Calibration given = run.calibration_given.value_or(run.calibrations.front().calibration);
  // Holes as wide as those of a trajectory are.
  Trajectory stamps;
  for (const roles::CalibrationPoint& p : run.calibrations) stamps.push_back({p.t, Pose()});
  const TimeNs hole = evaluation::holeOf(stamps);
  const auto panel = [&](const char* y_label, int count, auto value, auto sigma) {
    evaluation::Panel out;
    out.y_label = y_label;
    for (int axis = 0; axis < count; ++axis) {
      addCalibrationCurve(
          run, hole, evaluation::figureColor(static_cast<std::size_t>(axis)),
          [&](const roles::CalibrationPoint& p) { return Vec2(value(p)[axis], sigma(p)); }, &out);
    }
    append(std::move(out), 130, &figure);
  };
  figure.entries = {{"x; or the only one", evaluation::figureColor(0)},
                    {"y", evaluation::figureColor(1)},
                    {"z", evaluation::figureColor(2)}};
  panel(
      "time offset [ms]", 1,
      [&](const roles::CalibrationPoint& p) {
        return Vec3(1e3 * (p.calibration.time_offset_s - given.time_offset_s), 0, 0);
      },
      [](const roles::CalibrationPoint& p) { return 1e3 * p.sigma.time_offset_s; });
  panel(
      "fx [px]", 1,
      [&](const roles::CalibrationPoint& p) {
        return Vec3(p.calibration.camera.fx - given.camera.fx, 0, 0);
      },
      [](const roles::CalibrationPoint& p) { return p.calibration.camera.fx * p.sigma.focal; });
  panel(
      "rotation [deg]", 3,
      [&](const roles::CalibrationPoint& p) {
        return Vec3(kDegPerRad * logQuat(given.T_B_C.q.conjugate() * p.calibration.T_B_C.q));
      },
      [](const roles::CalibrationPoint& p) { return kDegPerRad * p.sigma.rotation_rad; });
  panel(
      "position [mm]", 3,
      [&](const roles::CalibrationPoint& p) {
        return Vec3(1e3 * (p.calibration.T_B_C.p - given.T_B_C.p));
      },
      [](const roles::CalibrationPoint& p) { return 1e3 * p.sigma.position_m; });
  return figure;
}

evaluation::Figure cpuFigure(const RunPictures& run) {
  evaluation::Figure figure = emptyFigure("CPU time per frame", "as the estimator reports it");
  Trajectory stamps;
  double most = 0;
  for (const auto& [t, ms] : run.cpu_ms) {
    stamps.push_back({t, Pose()});
    most = std::max(most, ms);
  }
  if (!(most > 0)) return figure;
  evaluation::Panel panel;
  panel.y_label = "[ms]";
  panel.from_zero = true;
  evaluation::Curve curve{evaluation::figureColor(0), 1, {}};
  const auto stamp = [&](std::size_t i) { return run.cpu_ms[i].first; };
  for (const auto& stroke : evaluation::cutAtHoles(
           run.cpu_ms.size(), evaluation::holeOf(stamps), stamp,
           [&](std::size_t i) { return Vec2(seconds(run, stamp(i)), run.cpu_ms[i].second); })) {
    curve.strokes.push_back(limited(stroke));
  }
  panel.curves.push_back(curve);
  append(std::move(panel), 140, &figure);
  return figure;
}

}  // namespace vir::results
