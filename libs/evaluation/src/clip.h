#pragma once
/// Cutting lines and areas at a frame.
#include <vector>

#include "vir/geometry/so3.h"

namespace vir::evaluation {

/// An upright rectangle.
struct Frame {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();

  bool contains(const Vec2& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
};

/// The parts of a line that lie inside the frame (Liang and Barsky, per piece).
std::vector<std::vector<Vec2>> clipLine(const std::vector<Vec2>& line, const Frame& frame);

/// The part of an area that lies inside the frame (Sutherland and Hodgman); empty if none does.
std::vector<Vec2> clipArea(const std::vector<Vec2>& outline, const Frame& frame);

}  // namespace vir::evaluation
