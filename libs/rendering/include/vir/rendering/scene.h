#pragma once
/// A place made of axis-aligned boxes: one hollow (the room) and solid ones in it.
#include <vector>

#include "vir/geometry/so3.h"

namespace vir::rendering {

/// Corners in W [m], `low` below `high` in every axis.
struct Box {
  Vec3 low = Vec3::Zero();
  Vec3 high = Vec3::Zero();
  /// Boxes of the same look (0 or more) are painted alike, as one shelf is like another; -1: unlike
  /// any other.
  int look = -1;
  /// Is the point inside or nearer than `margin_m` along every axis?
  bool holds(const Vec3& p, double margin_m = 0) const {
    return ((p - low).array() > -margin_m).all() && ((high - p).array() > -margin_m).all();
  }
};

class Scene {
 public:
  /// Throws std::invalid_argument for a box that has no inside or is not finite, and beyond 5000
  /// boxes.
  Scene(const Box& interior, std::vector<Box> boxes);

  const Box& interior() const { return interior_; }
  const std::vector<Box>& boxes() const { return boxes_; }

  /// How much of the straight line from `a` to `b` runs inside solid boxes [m]. Where boxes overlap
  /// the overlap counts once per box. Symmetric.
  double solidBetween(const Vec3& a, const Vec3& b) const;
  /// Does a solid box or the room's wall stand between the two? A point on a surface is not hidden
  /// by that surface.
  bool hidden(const Vec3& a, const Vec3& b) const;

 private:
  Box interior_;
  std::vector<Box> boxes_;
};

}  // namespace vir::rendering
