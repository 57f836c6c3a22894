#pragma once
#include <deque>
#include <mutex>
#include <optional>

#include "vir/core/time.h"
#include "vir/types/imu_sample.h"
#include "vir/types/state.h"

namespace vir::live {

/// Carries the newest estimate on with the readings of the IMU, so that there is a pose per reading
/// with no delay but the IMU's. Any thread.
class PosePropagator {
 public:
  /// Gravity along -z of W [m/s^2]: that of the estimator.
  explicit PosePropagator(double gravity_mps2) : gravity_W_(0, 0, -gravity_mps2) {}
  /// An estimate, of a time that readings have passed already as a rule.
  void setState(const State& state);
  /// There is no estimate to go on from (lost, or not started).
  void clear();
  /// A reading, in time order; the state at its time, if there is an estimate not older than
  /// `kLongest`.
  std::optional<State> add(const ImuSample& sample);

  /// Without an estimate for so long, positions are no longer worth sending.
  static constexpr TimeNs kLongest = 500'000'000;

 private:
  void step(const ImuSample& from, const ImuSample& to);

  std::mutex mutex_;
  bool has_state_ = false;
  TimeNs state_t_ = 0;  // of the estimate
  const Vec3 gravity_W_;
  State at_;
  std::deque<ImuSample> samples_;
};

}  // namespace vir::live
