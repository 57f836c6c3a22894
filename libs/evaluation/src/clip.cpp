#include "clip.h"

#include <algorithm>

namespace vir::evaluation {
namespace {

/// Narrows [from, to] of the piece a + s (b - a) to what is inside; false if nothing is.
bool insidePart(const Vec2& a, const Vec2& b, const Frame& frame, double* from, double* to) {
  const Vec2 d = b - a;
  *from = 0;
  *to = 1;
  for (int k = 0; k < 2; ++k) {
    for (const bool upper : {false, true}) {
      const double slope = upper ? d[k] : -d[k];
      const double room = upper ? frame.high[k] - a[k] : a[k] - frame.low[k];
      if (slope == 0) {
        if (room < 0) return false;
      } else if (slope > 0) {
        *to = std::min(*to, room / slope);
      } else {
        *from = std::max(*from, room / slope);
      }
    }
  }
  return *from <= *to;
}

}  // namespace

std::vector<std::vector<Vec2>> clipLine(const std::vector<Vec2>& line, const Frame& frame) {
  std::vector<std::vector<Vec2>> parts;
  bool open = false;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec2 &a = line[i], &b = line[i + 1];
    double from = 0, to = 1;
    if (!a.allFinite() || !b.allFinite() || !insidePart(a, b, frame, &from, &to)) {
      open = false;
      continue;
    }
    if (!open || from > 0) parts.push_back({a + from * (b - a)});
    parts.back().push_back(a + to * (b - a));
    open = to >= 1;
  }
  return parts;
}

std::vector<Vec2> clipArea(const std::vector<Vec2>& outline, const Frame& frame) {
  std::vector<Vec2> area;
  for (const Vec2& p : outline) {
    if (p.allFinite()) area.push_back(p);
  }
  for (int k = 0; k < 2; ++k) {
    for (const bool upper : {false, true}) {
      const double edge = upper ? frame.high[k] : frame.low[k];
      const auto inside = [&](const Vec2& p) { return upper ? p[k] <= edge : p[k] >= edge; };
      std::vector<Vec2> kept;
      for (std::size_t i = 0; i < area.size(); ++i) {
        const Vec2 &a = area[i], &b = area[(i + 1) % area.size()];
        if (inside(a)) kept.push_back(a);
        if (inside(a) != inside(b)) kept.push_back(a + (edge - a[k]) / (b[k] - a[k]) * (b - a));
      }
      area.swap(kept);
    }
  }
  return area;
}

}  // namespace vir::evaluation
