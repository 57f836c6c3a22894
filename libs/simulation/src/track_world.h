#pragma once
/// The points of a simulated room, in blocks so that those out of sight cost nothing.
#include <cstdint>
#include <vector>

#include "vir/simulation/track_simulator.h"

namespace vir::simulation {

class TrackWorld {
 public:
  struct Block {
    Vec3 centre = Vec3::Zero();
    double radius = 0;
    std::size_t begin = 0, end = 0;  ///< of points()
  };
  /// Points on the surfaces of `scene`; without one, on the walls of a room around the motion and
  /// standing free in it.
  TrackWorld(const TrackSimulationOptions& options, const Motion& motion,
             const rendering::Scene* scene);

  const std::vector<Vec3>& points() const { return points_; }
  const std::vector<Block>& blocks() const { return blocks_; }

 private:
  void addWalls(const TrackSimulationOptions& o, const Vec3& low, const Vec3& high);
  void addFree(const TrackSimulationOptions& o, const Motion& motion, const Vec3& low,
               const Vec3& high);
  void addSurfaces(const TrackSimulationOptions& o, const rendering::Scene& scene);
  void sortIntoBlocks();

  std::vector<Vec3> points_;
  std::vector<Block> blocks_;
};

}  // namespace vir::simulation
