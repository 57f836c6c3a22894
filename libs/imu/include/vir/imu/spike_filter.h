#pragma once
/// Single readings that cannot be: a bit that fell over on the bus, a sensor that restarts. One of
/// them turns or throws the path for good.
#include <cstddef>
#include <optional>
#include <vector>

#include "vir/types/imu_sample.h"

namespace vir::imu {

class SpikeFilter {
 public:
  /// Takes the next reading and returns those that may be used now, oldest first: usually just this
  /// one; none while it is not clear yet whether it is a spike (a few readings at most). A spike is
  /// far from its neighbours on both sides, measured by how the readings have changed so far, while
  /// those agree: a blow or a turn that begins changes all that follow. Of the first reading of
  /// all, which has no neighbour before it, only beyond 5 rad/s or 50 m/s^2 is doubted. Not finite
  /// ones and those that are not later than the one before go through: who takes them counts them.
  const std::vector<ImuSample>& add(const ImuSample& s);

  /// The clock was set back: what comes now has nothing to do with what came before.
  void restart();

  long spikes() const { return spikes_; }          ///< left out, far from both neighbours
  long impossible() const { return impossible_; }  ///< left out, beyond what any IMU can read

 private:
  /// So many readings lie between them.
  bool far(const ImuSample& a, const ImuSample& b, std::size_t between) const;
  /// The first reading of all.
  void begin(const ImuSample& s);
  void accept(const ImuSample& s);
  void acceptPending();

  std::optional<ImuSample> last_;    ///< accepted
  std::vector<ImuSample> pending_;   ///< may be spikes
  std::vector<ImuSample> accepted_;  ///< by the last add()
  double gyro_change_ = 0;           ///< from reading to reading, on average [rad/s]
  double acc_change_ = 0;            ///< [m/s^2]
  int known_ = 0;                    ///< readings that average stands for
  long spikes_ = 0, impossible_ = 0;
};

}  // namespace vir::imu
