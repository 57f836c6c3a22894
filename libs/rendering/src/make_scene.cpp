#include "vir/rendering/make_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vir/core/random.h"

namespace vir::rendering {
namespace {

/// Corridors are cut out of blocks of this size [m].
constexpr double kCell_m = 0.5;
constexpr int kMaxCells = 400000;
/// Nothing may touch an anchor [m].
constexpr double kAnchorClearance_m = 0.15;
constexpr int kTriesPerBox = 30;

double distance(const Box& box, const Vec3& p) {
  return (p - p.cwiseMax(box.low).cwiseMin(box.high)).norm();
}

Box around(const std::vector<Vec3>& points) {
  Box b{points.front(), points.front()};
  for (const Vec3& p : points) {
    b.low = b.low.cwiseMin(p);
    b.high = b.high.cwiseMax(p);
  }
  return b;
}

class Builder {
 public:
  Builder(const SceneOptions& o, const std::vector<Vec3>& paths, const std::vector<Vec3>& clear)
      : o_(o), paths_(paths), clear_(clear), random_(static_cast<std::uint64_t>(o.seed), 500) {
    room_ = around(paths);
    room_.low -= Vec3(o.margin_m, o.margin_m, o.below_m);
    room_.high += Vec3(o.margin_m, o.margin_m, o.above_m);
    for (const Vec3& p : clear_) {
      room_.low = room_.low.cwiseMin(p - Vec3::Constant(0.3));
      room_.high = room_.high.cwiseMax(p + Vec3::Constant(0.3));
    }
  }

  void fillBetweenCorridors();
  void furnish();
  Scene scene() { return Scene(room_, std::move(boxes_)); }

 private:
  bool fits(const Box& box) const;
  /// A box of a size, somewhere.
  Box crate();
  Box pillar();
  Box beam();
  Box cabinet();
  /// A wall to put a cabinet at: of the room or of a solid block.
  Box wallPatch(double width, double depth, double low, double high);

  const SceneOptions& o_;
  const std::vector<Vec3>& paths_;
  const std::vector<Vec3>& clear_;
  Random random_;
  Box room_;
  std::vector<Box> boxes_;
  std::size_t blocks_ = 0;  ///< the first of boxes_ that are solid between corridors
};

bool Builder::fits(const Box& box) const {
  const auto far = [&](double limit) {
    return [&box, limit](const Vec3& p) { return distance(box, p) >= limit; };
  };
  return (box.high - box.low).minCoeff() > 0.02 &&
         std::all_of(paths_.begin(), paths_.end(), far(o_.clearance_m)) &&
         std::all_of(clear_.begin(), clear_.end(), far(kAnchorClearance_m));
}

void Builder::fillBetweenCorridors() {
  const Vec3 size = room_.high - room_.low;
  const double cell = std::max(kCell_m, std::sqrt(size.x() * size.y() / kMaxCells));
  const int nx = static_cast<int>(std::ceil(size.x() / cell));
  const int ny = static_cast<int>(std::ceil(size.y() / cell));
  std::vector<char> solid(static_cast<std::size_t>(nx * ny), 1);
  const auto at = [&](int x, int y) -> char& {
    return solid[static_cast<std::size_t>(y * nx + x)];
  };
  const auto open = [&](const Vec3& p, double reach) {
    const int r = static_cast<int>(std::ceil(reach / cell));
    const int cx = static_cast<int>((p.x() - room_.low.x()) / cell);
    const int cy = static_cast<int>((p.y() - room_.low.y()) / cell);
    for (int y = std::max(0, cy - r); y <= std::min(ny - 1, cy + r); ++y) {
      for (int x = std::max(0, cx - r); x <= std::min(nx - 1, cx + r); ++x) {
        // A corridor has straight walls: the larger of the two distances counts.
        const double dx = std::abs(room_.low.x() + (x + 0.5) * cell - p.x());
        const double dy = std::abs(room_.low.y() + (y + 0.5) * cell - p.y());
        if (std::max(dx, dy) < reach) at(x, y) = 0;
      }
    }
  };
  const double reach = std::max(o_.corridor_half_width_m, o_.clearance_m + cell);
  for (const Vec3& p : paths_) open(p, reach);
  for (const Vec3& p : clear_) open(p, kAnchorClearance_m + cell);
  // Solid cells become as few boxes as a greedy sweep finds.
  for (int y = 0; y < ny; ++y) {
    for (int x = 0; x < nx; ++x) {
      if (!at(x, y)) continue;
      int x1 = x;
      while (x1 < nx && at(x1, y)) ++x1;
      int y1 = y + 1;
      const auto fullRow = [&](int row) {
        for (int k = x; k < x1; ++k) {
          if (!at(k, row)) return false;
        }
        return true;
      };
      while (y1 < ny && fullRow(y1)) ++y1;
      for (int row = y; row < y1; ++row) {
        for (int k = x; k < x1; ++k) at(k, row) = 0;
      }
      const Vec3 low(room_.low.x() + x * cell, room_.low.y() + y * cell, room_.low.z());
      const Vec3 high(room_.low.x() + x1 * cell, room_.low.y() + y1 * cell, room_.high.z());
      boxes_.push_back({low, high.cwiseMin(room_.high)});
    }
  }
  blocks_ = boxes_.size();
}

Box Builder::crate() {
  const Vec3 size(random_.uniform(0.3, 1.3), random_.uniform(0.3, 1.3), random_.uniform(0.3, 1.4));
  Vec3 low = room_.low;
  for (int k = 0; k < 2; ++k) low[k] = random_.uniform(room_.low[k], room_.high[k] - size[k]);
  return {low, low + size};
}

Box Builder::pillar() {
  Box b = crate();
  const double width = random_.uniform(0.2, 0.5);
  b.high = b.low + Vec3(width, width, 0);
  b.high.z() = room_.high.z();
  return b;
}

Box Builder::beam() {
  const int along = random_.uniform() < 0.5 ? 0 : 1;
  const double width = random_.uniform(0.15, 0.5), drop = random_.uniform(0.1, 0.4);
  Box b = room_;
  b.low.z() = room_.high.z() - drop;
  const int across = 1 - along;
  b.low[across] = random_.uniform(room_.low[across], room_.high[across] - width);
  b.high[across] = b.low[across] + width;
  return b;
}

Box Builder::wallPatch(double width, double depth, double low, double high) {
  // Inside of the room, or outside of a block between corridors.
  const auto blocks = static_cast<double>(blocks_);
  const bool of_block = blocks_ > 0 && random_.uniform() < 0.8;
  const Box& wall = of_block ? boxes_[static_cast<std::size_t>(random_.uniform() * blocks)] : room_;
  const int across = random_.uniform() < 0.5 ? 0 : 1, along = 1 - across;
  const bool upper = random_.uniform() < 0.5;
  const double start = random_.uniform(wall.low[along], wall.high[along] - width);
  Box b;
  b.low[along] = start;
  b.high[along] = start + width;
  b.low.z() = low;
  b.high.z() = high;
  const double face = upper ? wall.high[across] : wall.low[across];
  const bool grows_up = upper == of_block;
  b.low[across] = grows_up ? face : face - depth;
  b.high[across] = grows_up ? face + depth : face;
  b.low = b.low.cwiseMax(room_.low);
  b.high = b.high.cwiseMin(room_.high);
  return b;
}

Box Builder::cabinet() {
  const double height = room_.high.z() - room_.low.z();
  const double width = random_.uniform(0.3, 1.8), depth = random_.uniform(0.05, 0.6);
  // Some stand on the floor, some hang on the wall.
  const double bottom = random_.uniform() < 0.4 ? 0 : random_.uniform(0, 0.7 * height);
  const double top = std::min(height, bottom + random_.uniform(0.3, 1.8));
  return wallPatch(width, depth, room_.low.z() + bottom, room_.low.z() + top);
}

void Builder::furnish() {
  const bool open = blocks_ == 0;
  for (int k = 0; k < o_.boxes; ++k) {
    for (int attempt = 0; attempt < kTriesPerBox; ++attempt) {
      const double kind = random_.uniform();
      Box b;
      if (kind < (open ? 0.45 : 0.85)) {
        b = cabinet();
      } else if (kind < (open ? 0.75 : 0.92)) {
        b = crate();
      } else if (kind < (open ? 0.87 : 0.92)) {
        b = pillar();
      } else {
        b = beam();
      }
      if (!fits(b)) continue;
      boxes_.push_back(b);
      break;
    }
  }
}

}  // namespace

Scene makeScene(const SceneOptions& o, const std::vector<Vec3>& paths,
                const std::vector<Vec3>& keep_clear) {
  if (paths.empty()) throw std::invalid_argument("makeScene: no path to build around");
  Builder builder(o, paths, keep_clear);
  if (o.layout == "corridors") {
    builder.fillBetweenCorridors();
  } else if (o.layout != "room") {
    throw std::invalid_argument("makeScene: layout '" + o.layout +
                                "' is unknown; known are room, corridors");
  }
  builder.furnish();
  return builder.scene();
}

}  // namespace vir::rendering
