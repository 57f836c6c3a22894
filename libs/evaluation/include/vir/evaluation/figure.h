#pragma once
/// A small line-plot: panels with axes, ticks and a common legend, drawn on any canvas.
#include <memory>
#include <string>
#include <vector>

#include "vir/evaluation/evaluate.h"
#include "vir/evaluation/trajectory.h"

namespace vir::evaluation {

struct Color {
  int r = 0, g = 0, b = 0;  ///< 0..255
};

/// Where a figure is drawn. Coordinates in px, origin at the top left, y down.
class Canvas {
 public:
  enum class Anchor { start, middle, end };
  virtual ~Canvas() = default;
  virtual void polyline(const std::vector<Vec2>& points, Color color, double width) = 0;
  /// Filled circle.
  virtual void dot(const Vec2& centre, double radius, Color color) = 0;
  /// Filled area, closed by itself; `opacity` 0..1.
  virtual void polygon(const std::vector<Vec2>& outline, Color color, double opacity) = 0;
  /// `at` is on the base line; `upward` turns the text by 90 deg against the clock.
  virtual void text(const Vec2& at, const std::string& text, double size, Anchor anchor,
                    Color color, bool upward) = 0;
};

/// Points joined by lines; several strokes where the data have holes.
struct Curve {
  Color color;
  double width = 1.5;  ///< [px]
  std::vector<std::vector<Vec2>> strokes;
  bool in_scale = true;  ///< the axes reach all of it; false: what is outside is not drawn
};

/// Filled; does not stretch the axes, what is outside is not drawn.
struct Area {
  Color color;
  double opacity = 0.2;  ///< 0..1
  std::vector<Vec2> outline;
};

/// A point with a sign.
struct Mark {
  enum class Shape { dot, ring, cross };
  Vec2 at = Vec2::Zero();
  Color color;
  double radius = 4;  ///< [px]
  Shape shape = Shape::dot;
  std::string label;  ///< to its right; may be empty
};

struct Panel {
  Vec2 corner = Vec2::Zero();  ///< top left of the area inside the axes [px]
  Vec2 size = Vec2::Zero();    ///< of that area [px]
  std::string title, x_label, y_label;
  bool equal_aspect = false;  ///< one metre is as long in x as in y
  bool from_zero = false;     ///< the y axis starts at 0
  std::vector<Curve> curves;
  std::vector<std::pair<Vec2, Color>> dots;  ///< in data coordinates
  std::vector<Area> areas;                   ///< below everything else
  std::vector<Mark> marks;
  std::vector<Vec2> extent;  ///< points the axes must reach beside curves and marks
};

struct LegendEntry {
  std::string text;
  Color color;
};

struct Figure {
  double width = 0, height = 0;  ///< [px]
  std::string title, subtitle;
  Vec2 legend = Vec2::Zero();  ///< top left of the legend, one line of 20 px per entry [px]
  std::vector<LegendEntry> entries;
  std::vector<Panel> panels;
};

/// Values at which an axis from `low` to `high` is labelled: multiples of 1, 2 or 5 times a power
/// of ten, about `wanted` of them, never more than twice that.
std::vector<double> axisTicks(double low, double high, int wanted);

void draw(const Figure& figure, Canvas* canvas);

/// The figure as a complete SVG document.
std::string toSvg(const Figure& figure);

/// The same as an element to be put into a page.
std::string toSvgElement(const Figure& figure);

struct NamedResult {
  std::string name;
  EvaluationResult result;
};

/// Paths from above and from the side after alignment, and the errors over time, against the
/// reference. `subtitle` says how the comparison was made.
Figure comparisonFigure(const Trajectory& reference, const std::vector<NamedResult>& estimates,
                        const std::string& subtitle);

}  // namespace vir::evaluation
