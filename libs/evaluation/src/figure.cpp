#include "vir/evaluation/figure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "clip.h"
#include "vir/core/angles.h"

namespace vir::evaluation {
namespace {

const Color kInk{40, 40, 40};
const Color kGrid{225, 225, 225};

struct Range {
  double low = 0, high = 1;
  double span() const { return high - low; }
};

/// Axis ranges of a panel and the way from data to px.
struct Axes {
  Range x, y;
  Vec2 corner, size;
  Vec2 toPx(const Vec2& v) const {
    return {corner.x() + (v.x() - x.low) / x.span() * size.x(),
            corner.y() + (y.high - v.y()) / y.span() * size.y()};
  }
};

void widen(Range* r, double span) {
  const double middle = 0.5 * (r->low + r->high);
  r->low = middle - 0.5 * span;
  r->high = middle + 0.5 * span;
}

/// Range of the data with a margin; never empty.
Range padded(double low, double high, double margin) {
  if (!(low <= high)) return {0, 1};
  const double least = 1e-6 * std::max({1.0, std::abs(low), std::abs(high)});
  Range r{low, high};
  widen(&r, std::max(r.span() * (1 + 2 * margin), least));
  return r;
}

/// Calls visit(point) for all that the axes must reach.
template <typename Visit>
void forEachPoint(const Panel& panel, Visit visit) {
  for (const Curve& curve : panel.curves) {
    if (!curve.in_scale) continue;
    for (const std::vector<Vec2>& stroke : curve.strokes)
      std::for_each(stroke.begin(), stroke.end(), visit);
  }
  for (const Mark& mark : panel.marks) visit(mark.at);
  std::for_each(panel.extent.begin(), panel.extent.end(), visit);
}

Axes axesOf(const Panel& panel) {
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  forEachPoint(panel, [&](const Vec2& v) {
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], v[k]);
      high[k] = std::max(high[k], v[k]);
    }
  });
  Axes axes;
  axes.corner = panel.corner;
  axes.size = panel.size;
  axes.x = padded(low[0], high[0], panel.equal_aspect ? 0.05 : 0.0);
  axes.y = padded(low[1], high[1], 0.06);
  if (panel.from_zero) axes.y = {0, std::max(high[1] * 1.08, 1e-9)};
  if (panel.equal_aspect) {
    const double per_px = std::max(axes.x.span() / panel.size.x(), axes.y.span() / panel.size.y());
    widen(&axes.x, per_px * panel.size.x());
    widen(&axes.y, per_px * panel.size.y());
  }
  return axes;
}

std::string tickText(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, std::abs(value) < 1e-9 * step ? 0.0 : value);
  return text;
}

void drawAxes(const Panel& panel, const Axes& axes, Canvas* canvas) {
  const Vec2 end = panel.corner + panel.size;
  const auto step = [](const std::vector<double>& t) { return t.size() > 1 ? t[1] - t[0] : 1.0; };
  const std::vector<double> xs =
      axisTicks(axes.x.low, axes.x.high, std::max(3, static_cast<int>(panel.size.x() / 80)));
  for (const double v : xs) {
    const double px = axes.toPx({v, axes.y.low}).x();
    canvas->polyline({{px, panel.corner.y()}, {px, end.y()}}, kGrid, 1);
    canvas->text({px, end.y() + 17}, tickText(v, step(xs)), 12, Canvas::Anchor::middle, kInk,
                 false);
  }
  const std::vector<double> ys =
      axisTicks(axes.y.low, axes.y.high, std::max(4, static_cast<int>(panel.size.y() / 45)));
  for (const double v : ys) {
    const double px = axes.toPx({axes.x.low, v}).y();
    canvas->polyline({{panel.corner.x(), px}, {end.x(), px}}, kGrid, 1);
    canvas->text({panel.corner.x() - 6, px + 4}, tickText(v, step(ys)), 12, Canvas::Anchor::end,
                 kInk, false);
  }
  canvas->polyline(
      {panel.corner, {end.x(), panel.corner.y()}, end, {panel.corner.x(), end.y()}, panel.corner},
      kInk, 1);
  const Vec2 middle = 0.5 * (panel.corner + end);
  canvas->text({middle.x(), end.y() + 36}, panel.x_label, 13, Canvas::Anchor::middle, kInk, false);
  canvas->text({panel.corner.x() - 52, middle.y()}, panel.y_label, 13, Canvas::Anchor::middle, kInk,
               true);
  canvas->text({panel.corner.x(), panel.corner.y() - 8}, panel.title, 14, Canvas::Anchor::start,
               kInk, false);
}

/// A stroke in px without the points too close together to be seen.
std::vector<Vec2> thinned(const std::vector<Vec2>& stroke, const Axes& axes) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < stroke.size(); ++i) {
    const Vec2 px = axes.toPx(stroke[i]);
    const bool last = i + 1 == stroke.size();
    if (points.empty() || last || (px - points.back()).norm() > 0.6) points.push_back(px);
  }
  return points;
}

void drawCurve(const Curve& curve, const Axes& axes, const Frame& frame, Canvas* canvas) {
  for (const std::vector<Vec2>& stroke : curve.strokes) {
    const std::vector<Vec2> points = thinned(stroke, axes);
    if (curve.in_scale) {
      canvas->polyline(points, curve.color, curve.width);
      continue;
    }
    for (const auto& part : clipLine(points, frame)) {
      canvas->polyline(part, curve.color, curve.width);
    }
  }
}

void drawMark(const Mark& mark, const Vec2& at, Canvas* canvas) {
  const double r = mark.radius;
  if (mark.shape == Mark::Shape::dot) canvas->dot(at, r, mark.color);
  if (mark.shape == Mark::Shape::cross) {
    canvas->polyline({at - Vec2(r, r), at + Vec2(r, r)}, mark.color, 2);
    canvas->polyline({at - Vec2(r, -r), at + Vec2(r, -r)}, mark.color, 2);
  }
  if (mark.shape == Mark::Shape::ring) {
    std::vector<Vec2> circle;
    for (int i = 0; i <= 24; ++i) {
      const double angle = 2 * kPi * i / 24;
      circle.push_back(at + r * Vec2(std::cos(angle), std::sin(angle)));
    }
    canvas->polyline(circle, mark.color, 1.6);
  }
  if (mark.label.empty()) return;
  // A ring often lies on a dot: its label goes below, not onto the other one.
  const double down = mark.shape == Mark::Shape::ring ? r + 10 : -r;
  canvas->text(at + Vec2(r + 4, down), mark.label, 12, Canvas::Anchor::start, mark.color, false);
}

void drawPanel(const Panel& panel, Canvas* canvas) {
  const Axes axes = axesOf(panel);
  const Frame frame{panel.corner, panel.corner + panel.size};
  for (const Area& area : panel.areas) {
    std::vector<Vec2> outline;
    for (const Vec2& v : area.outline) outline.push_back(axes.toPx(v));
    outline = clipArea(outline, frame);
    if (outline.size() > 2) canvas->polygon(outline, area.color, area.opacity);
  }
  drawAxes(panel, axes, canvas);
  for (const Curve& curve : panel.curves) drawCurve(curve, axes, frame, canvas);
  for (const auto& [v, color] : panel.dots) canvas->dot(axes.toPx(v), 4, color);
  for (const Mark& mark : panel.marks) drawMark(mark, axes.toPx(mark.at), canvas);
}

}  // namespace

std::vector<double> axisTicks(double low, double high, int wanted) {
  std::vector<double> ticks;
  if (!(high > low) || wanted < 1 || !std::isfinite(high - low)) return ticks;
  const double raw = (high - low) / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= 0.7 * raw) {
      step = factor * power;
      break;
    }
  }
  const double first = std::ceil(low / step - 1e-9);
  for (int i = 0; i <= 2 * wanted; ++i) {
    const double v = (first + i) * step;
    if (v > high + 1e-9 * step) break;
    ticks.push_back(v);
  }
  return ticks;
}

void draw(const Figure& figure, Canvas* canvas) {
  canvas->text({20, 30}, figure.title, 19, Canvas::Anchor::start, kInk, false);
  canvas->text({20, 52}, figure.subtitle, 13, Canvas::Anchor::start, kInk, false);
  Vec2 at = figure.legend + Vec2(0, 10);
  for (const LegendEntry& entry : figure.entries) {
    canvas->polyline({at, at + Vec2(28, 0)}, entry.color, 3);
    canvas->text(at + Vec2(36, 4), entry.text, 13, Canvas::Anchor::start, kInk, false);
    at.y() += 20;
  }
  for (const Panel& panel : figure.panels) drawPanel(panel, canvas);
}

}  // namespace vir::evaluation
