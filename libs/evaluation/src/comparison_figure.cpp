#include <algorithm>
#include <cstdio>

#include "vir/evaluation/figure_parts.h"

namespace vir::evaluation {
namespace {

const Color kReference{120, 120, 120};

/// The part of the reference the estimates are compared with, so that a short run is not a speck on
/// a long recording.
Trajectory usedPart(const Trajectory& reference, const std::vector<NamedResult>& estimates) {
  TimeNs from = reference.back().t, to = reference.front().t;
  for (const NamedResult& e : estimates) {
    from = std::min(from, e.result.association.pairs.front().t);
    to = std::max(to, e.result.association.pairs.back().t);
  }
  Trajectory part;
  for (const StampedPose& pose : reference) {
    if (pose.t >= from && pose.t <= to) part.push_back(pose);
  }
  return part.empty() ? reference : part;
}

Panel pathPanel(const Trajectory& reference, const std::vector<NamedResult>& estimates, int a,
                int b) {
  static const char* const labels[] = {"x [m]", "y [m]", "z [m]"};
  constexpr TimeNs hole = 500000000;
  Panel panel;
  panel.equal_aspect = true;
  panel.x_label = labels[a];
  panel.y_label = labels[b];
  panel.curves.push_back({kReference, 3, pathStrokes(reference, a, b, hole)});
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    const EvaluationResult& r = estimates[k].result;
    panel.curves.push_back(
        {figureColor(k), 1.5,
         cutAtHoles(
             r.aligned.size(), hole, [&](std::size_t i) { return r.association.pairs[i].t; },
             [&](std::size_t i) { return Vec2(r.aligned[i].p[a], r.aligned[i].p[b]); })});
    panel.dots.push_back({panel.curves.back().strokes.front().front(), figureColor(k)});
  }
  return panel;
}

Panel errorPanel(TimeNs start, const std::vector<NamedResult>& estimates,
                 std::vector<double> EvaluationResult::*errors) {
  Panel panel;
  panel.from_zero = true;
  panel.x_label = "time since the first pose compared [s]";
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    const EvaluationResult& r = estimates[k].result;
    const auto stamp = [&](std::size_t i) { return r.association.pairs[i].t; };
    panel.curves.push_back(
        {figureColor(k), 1.5, cutAtHoles(r.aligned.size(), 500000000, stamp, [&](std::size_t i) {
           return Vec2(toSeconds(stamp(i) - start), (r.*errors)[i]);
         })});
  }
  return panel;
}

std::string legendText(const NamedResult& e) {
  char text[160], attitude[32] = "";
  if (e.result.attitudes) {
    std::snprintf(attitude, sizeof attitude, ", %.2f deg", e.result.ate_orientation_deg.rmse);
  }
  std::snprintf(text, sizeof text, ": ATE %.4f m rmse%s; covers %.1f %%",
                e.result.ate_position_m.rmse, attitude, 100 * e.result.association.coverage);
  return e.name + text;
}

}  // namespace

Figure comparisonFigure(const Trajectory& reference, const std::vector<NamedResult>& estimates,
                        const std::string& subtitle) {
  Figure figure;
  figure.width = 1200;
  figure.title = "Estimate against reference";
  figure.subtitle = subtitle;
  figure.legend = {20, 64};
  if (reference.empty() || estimates.empty()) {
    figure.height = 120;
    return figure;
  }
  figure.entries.push_back({"reference (a dot marks where an estimate begins)", kReference});
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    figure.entries.push_back({legendText(estimates[k]), figureColor(k)});
  }
  const Trajectory part = usedPart(reference, estimates);
  const double top = 64 + 20 * static_cast<double>(figure.entries.size()) + 40;
  const int axis = longerHorizontalAxis(part);

  const auto place = [&](Panel panel, const char* title, Vec2 corner, Vec2 size) {
    panel.title = title;
    panel.corner = corner;
    panel.size = size;
    figure.panels.push_back(std::move(panel));
  };
  place(pathPanel(part, estimates, 0, 1), "From above", {80, top}, {490, 440});
  place(pathPanel(part, estimates, axis, 2), "From the side", {680, top}, {490, 440});
  Panel position = errorPanel(part.front().t, estimates, &EvaluationResult::position_error_m);
  position.y_label = "error [m]";
  place(std::move(position), "Position error", {80, top + 520}, {1090, 170});
  Panel attitude = errorPanel(part.front().t, estimates, &EvaluationResult::orientation_error_deg);
  attitude.y_label = "error [deg]";
  place(std::move(attitude), "Orientation error", {80, top + 770}, {1090, 130});
  figure.height = top + 770 + 130 + 60;
  return figure;
}

}  // namespace vir::evaluation
