#pragma once
/// What one pair of antennas does to their ranges.
#include "vir/core/random.h"
#include "vir/rendering/scene.h"
#include "vir/simulation/simulate_ranges.h"

namespace vir::simulation {

/// Remembers what changes slowly: the correlated error, and whether something stands in the way.
class RangeChannel {
 public:
  /// `stream` chooses the random numbers; `scene` may be null. Both arguments outlive the channel.
  RangeChannel(const RangeSimulationOptions& options, std::uint64_t stream,
               const rendering::Scene* scene);

  /// In periods, to either side.
  double jitter() { return o_.jitter * random_.uniform(-1, 1); }
  /// From antenna to antenna, `dt` seconds after the one before. Fills all but time and id. Draws
  /// the same number of random numbers whatever the settings.
  SimulatedRange measure(const Vec3& a, const Vec3& b, double dt);
  /// Did the last range get through?
  bool lost() const { return lost_; }

 private:
  void updateBlocked(double dt, double block, double length);

  const RangeSimulationOptions& o_;
  const rendering::Scene* scene_;
  Random random_;
  double correlated_ = 0;
  double excess_ = 0;  ///< of the obstacle that was drawn [m]
  double scene_excess_ = 0;
  bool blocked_ = false, scene_blocked_ = false, lost_ = false, started_ = false;
};

/// Throws std::invalid_argument for lists of the wrong length.
void checkRangeOptions(const RangeSimulationOptions& options);
int anchorId(const RangeSimulationOptions& options, std::size_t index);

}  // namespace vir::simulation
