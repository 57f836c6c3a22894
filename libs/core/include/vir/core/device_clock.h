#pragma once
/// From a device's own time stamps to the host's clock.
#include <cstdint>
#include <deque>
#include <optional>

#include "vir/core/time.h"

namespace vir {
inline namespace core {

struct DeviceClockOptions {
  TimeNs wrap = 0;                      ///< the device counts from 0 again after this; 0 = never
  double max_drift_ppm = 500;           ///< a crystal is never farther off
  TimeNs window = 60'000'000'000;       ///< how far back the fit looks
  TimeNs bucket = 1'000'000'000;        ///< one point of the fit for each
  TimeNs drift_after = 10'000'000'000;  ///< the drift is fitted once there is data of this length
  TimeNs tolerance = 100'000'000;       ///< a stamp so far ahead of its arrival contradicts the fit
  TimeNs max_late = 5'000'000'000;      ///< and one that arrives so late
  int confirmations = 5;                ///< contradicting samples in a row that mean a restart
  TimeNs shift_after = 4'000'000'000;   ///< nothing timely for so long: the clocks have shifted
  TimeNs min_step = 100;                ///< between two results (MRPT's clock ticks in 100 ns)
};

/// Maps device stamps to host time: host = device + offset + drift * device. A message is never
/// early, only late, by delays that vary, so the line sought is the one below all points (device
/// stamp, arrival - device stamp) that is closest to them: the edge of their lower convex hull over
/// the middle of the data (Moon, Skelly, Towsley, "Estimation and removal of clock skew from
/// network delay measurements", INFOCOM 1999). The smallest delay itself cannot be seen and stays
/// in the result.
///
/// Results grow strictly, never lie after the arrival (unless only that keeps them growing), and at
/// a restart of the device, or a step of either clock, go on from the arrival time.
class DeviceClock {
 public:
  explicit DeviceClock(const DeviceClockOptions& options = {}) : options_(options) {}

  /// Host time of a message stamped `device` by the device [ns, 0 <= device < wrap] that arrived at
  /// `arrival` on the host's clock.
  TimeNs stamp(TimeNs device, TimeNs arrival);
  /// The host has slept so long in all (hostSlept(), [ns]): to be said before stamp(). A device
  /// that slept with it shows by what comes next, all late by the sleep: its stamps are arrival
  /// times until that is sure.
  void hostSlept(TimeNs in_all);

  /// Host clock rate over device clock rate - 1 [1e-6].
  double driftPpm() const { return drift_ * 1e6; }
  /// True once the drift is fitted to data.
  bool driftKnown() const { return drift_known_; }
  /// The device started again, or a clock was set.
  long restarts() const { return restarts_; }
  /// Single stamps that fit nothing around them; their results are arrival times.
  long glitches() const { return glitches_; }

 private:
  struct Point {
    TimeNs device = 0;    ///< unwrapped
    TimeNs residual = 0;  ///< arrival - device
  };

  TimeNs forward(TimeNs from, TimeNs to) const;
  TimeNs map(TimeNs device) const;
  void start(TimeNs raw, TimeNs device, TimeNs arrival);
  TimeNs contradicted(TimeNs raw, TimeNs arrival);
  bool shifted(TimeNs arrival, TimeNs late);
  bool sleptToo(TimeNs arrival, TimeNs late);
  void learn(TimeNs device, TimeNs arrival);
  void fit();
  double hullSlope() const;
  TimeNs emit(TimeNs t, TimeNs step, TimeNs arrival);

  DeviceClockOptions options_;
  bool started_ = false, drift_known_ = false, any_out_ = false;
  TimeNs last_raw_ = 0, last_device_ = 0, last_out_ = 0;
  std::deque<Point> points_;  ///< smallest residual of each bucket
  double drift_ = 0;
  Point anchor_;          ///< the line goes through here ...
  double offset_ns_ = 0;  ///< ... plus this
  int suspects_ = 0;
  TimeNs suspect_raw_ = 0, suspect_arrival_ = 0;
  TimeNs period_start_ = 0, period_least_late_ = 0;
  int period_samples_ = 0;
  std::optional<TimeNs> slept_;  ///< by the host in all, as last said
  TimeNs sleep_ = 0;             ///< did the device sleep as long? 0: that is not the question
  TimeNs woken_ = 0;             ///< the first arrival after it
  int as_late_as_sleep_ = 0;     ///< samples since then
  long restarts_ = 0, glitches_ = 0;
};

}  // namespace core
}  // namespace vir
