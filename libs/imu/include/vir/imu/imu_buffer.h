#pragma once
/// Readings waiting to be integrated between images.
#include <deque>
#include <optional>

#include "vir/imu/preintegration.h"
#include "vir/imu/saturation.h"

namespace vir::imu {

struct ImuBufferCounters {
  long accepted = 0;
  long not_finite = 0;    ///< NaN or infinite: dropped
  long out_of_order = 0;  ///< not later than the previous: dropped
  long gaps = 0;          ///< intervals longer than the limit that were bridged
  long holes = 0;         ///< of these, too long to be bridged
};

class ImuBuffer {
 public:
  /// An interval longer than `max_gap_s` counts as a gap: bridged, with inflated noise. One longer
  /// than `max_bridge_s` is a hole: integrate() goes across it, but what comes out says nothing.
  explicit ImuBuffer(double max_gap_s = 0.05, double max_bridge_s = 1.0)
      : max_gap_s_(max_gap_s), max_bridge_s_(max_bridge_s) {}

  /// Takes a reading; false (and counted) if it cannot be used.
  bool add(const ImuSample& s);
  /// Is there a reading at or after t, so that everything up to t can be integrated?
  bool covers(TimeNs t) const { return !samples_.empty() && samples_.back().t >= t; }
  /// Does t lie between two readings with a hole between them? Of the readings that are kept: what
  /// dropBefore() and clear() forget makes no hole.
  bool inHole(TimeNs t) const;
  bool empty() const { return samples_.empty(); }
  TimeNs firstTime() const { return samples_.front().t; }
  TimeNs lastTime() const { return samples_.back().t; }

  /// Integrates from t0 to t1, with readings interpolated at both ends. Where readings are missing
  /// (before the first, after the last, or in a gap) the nearest is held and the noise inflated;
  /// `gap` tells. It is inflated as much where readings are at the end of the sensor's range.
  /// Throws std::invalid_argument if t1 <= t0 or the buffer is empty.
  Preintegration integrate(TimeNs t0, TimeNs t1, const ImuNoise& noise, const Vec3& bias_gyro,
                           const Vec3& bias_acc, bool* gap = nullptr,
                           const ImuIntrinsics& intrinsics = ImuIntrinsics::Zero());

  /// Mean and standard deviation (norm over axes) of gyro and accelerometer in [t0, t1]; false if
  /// fewer than 3 readings are inside.
  bool statistics(TimeNs t0, TimeNs t1, Vec3* gyro_mean, Vec3* acc_mean, double* gyro_std,
                  double* acc_std) const;

  /// Readings per second in [t0, t1].
  double rate(TimeNs t0, TimeNs t1) const;

  /// Mean angular rate over [t0, t1], [rad/s]; false where readings do not cover it.
  bool meanGyro(TimeNs t0, TimeNs t1, Vec3* rate) const;

  /// Forgets what lies before t, except the last reading before it (needed to interpolate).
  void dropBefore(TimeNs t);
  void clear() {
    samples_.clear();
    saturated_.clear();
  }
  const ImuBufferCounters& counters() const { return counters_; }

 private:
  /// Readings at the end of the sensor's range, from the first to the last.
  struct Stretch {
    TimeNs first, last;
  };
  ImuSample at(TimeNs t) const;
  bool isSaturated(TimeNs t0, TimeNs t1) const;

  double max_gap_s_, max_bridge_s_;
  std::deque<ImuSample> samples_;
  SaturationCounter saturation_;
  std::deque<Stretch> saturated_;
  ImuBufferCounters counters_;
};

}  // namespace vir::imu
