#include "track_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "vir/core/random.h"

namespace vir::simulation {
namespace {

constexpr double kMaxWallPoints = 400000;
constexpr double kBlock_m = 3;
/// Nothing stands nearer to the path than this.
constexpr double kClearance_m = 0.6;
constexpr double kReach_m = 6;

Vec3 direction(Random* random) {
  const double x = random->normal(), y = random->normal(), z = random->normal();
  const Vec3 v(x, y, z);
  return v.norm() > 1e-6 ? v.normalized() : Vec3::UnitX();
}

}  // namespace

TrackWorld::TrackWorld(const TrackSimulationOptions& o, const Motion& motion,
                       const rendering::Scene* scene) {
  if (scene != nullptr) {
    addSurfaces(o, *scene);
    sortIntoBlocks();
    return;
  }
  Vec3 low = motion.poseAt(motion.begin()).p, high = low;
  for (const StampedPose& s : motion.sampled(10)) {
    low = low.cwiseMin(s.T_W_B.p);
    high = high.cwiseMax(s.T_W_B.p);
  }
  low.array() -= o.room_margin_m;
  high.array() += o.room_margin_m;
  addWalls(o, low, high);
  addFree(o, motion, low, high);
  sortIntoBlocks();
}

void TrackWorld::addWalls(const TrackSimulationOptions& o, const Vec3& low, const Vec3& high) {
  Random random(static_cast<std::uint64_t>(o.seed), 400);
  const Vec3 size = high - low;
  const double area = 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
  const double density = std::min(o.wall_density, kMaxWallPoints / area);
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const double wall : {low[axis], high[axis]}) {
      const auto count = static_cast<long>(density * size[u] * size[v]);
      for (long k = 0; k < count; ++k) {
        Vec3 p;
        // Shelves, pipes, boxes: no wall is flat.
        const double relief = 0.4 * std::pow(random.uniform(), 2) * (wall == low[axis] ? 1 : -1);
        p[axis] = wall + relief;
        p[u] = random.uniform(low[u], high[u]);
        p[v] = random.uniform(low[v], high[v]);
        points_.push_back(p);
      }
    }
  }
}

void TrackWorld::addFree(const TrackSimulationOptions& o, const Motion& motion, const Vec3& low,
                         const Vec3& high) {
  Random random(static_cast<std::uint64_t>(o.seed), 401);
  const Trajectory path = motion.sampled(2);
  const auto wanted = static_cast<std::size_t>(o.free_share * static_cast<double>(points_.size()));
  for (std::size_t k = 0; k < wanted; ++k) {
    const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(path.size()));
    const Vec3 p = path[at].T_W_B.p + random.uniform(kClearance_m, kReach_m) * direction(&random);
    if ((p - low).minCoeff() < 0 || (high - p).minCoeff() < 0) continue;
    bool clear = true;
    for (const StampedPose& s : path) clear = clear && (s.T_W_B.p - p).norm() > kClearance_m;
    if (clear) points_.push_back(p);
  }
}

void TrackWorld::addSurfaces(const TrackSimulationOptions& o, const rendering::Scene& scene) {
  Random random(static_cast<std::uint64_t>(o.seed), 402);
  double area = 0;
  const auto areaOf = [](const Vec3& size, int axis) {
    return size[(axis + 1) % 3] * size[(axis + 2) % 3];
  };
  std::vector<rendering::Box> all{scene.interior()};
  all.insert(all.end(), scene.boxes().begin(), scene.boxes().end());
  for (const rendering::Box& b : all) {
    for (int axis = 0; axis < 3; ++axis) area += 2 * areaOf(b.high - b.low, axis);
  }
  const double density = std::min(o.wall_density, kMaxWallPoints / area);
  for (const rendering::Box& b : all) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {b.low[axis], b.high[axis]}) {
        // A face too small for one point has one now and then.
        const double wanted = density * areaOf(b.high - b.low, axis) + random.uniform();
        for (int k = 0; k < static_cast<int>(wanted); ++k) {
          Vec3 p;
          for (int d = 0; d < 3; ++d) p[d] = random.uniform(b.low[d], b.high[d]);
          p[axis] = side;
          points_.push_back(p);
        }
      }
    }
  }
}

void TrackWorld::sortIntoBlocks() {
  std::map<std::array<int, 3>, std::vector<Vec3>> cells;
  for (const Vec3& p : points_) {
    const Vec3 c = p / kBlock_m;
    cells[{static_cast<int>(std::floor(c.x())), static_cast<int>(std::floor(c.y())),
           static_cast<int>(std::floor(c.z()))}]
        .push_back(p);
  }
  points_.clear();
  for (const auto& [cell, inside] : cells) {
    Block b;
    b.centre = kBlock_m * (Vec3(cell[0], cell[1], cell[2]) + Vec3::Constant(0.5));
    b.radius = 0.5 * std::sqrt(3.0) * kBlock_m;
    b.begin = points_.size();
    points_.insert(points_.end(), inside.begin(), inside.end());
    b.end = points_.size();
    blocks_.push_back(b);
  }
}

}  // namespace vir::simulation
