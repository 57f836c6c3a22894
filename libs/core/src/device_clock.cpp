#include "vir/core/device_clock.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vir {
inline namespace core {
namespace {

constexpr int kFewestInPeriod = 10;
/// What waited in buffers while the host slept comes at once after it; a device that slept too has
/// to measure first [ns].
constexpr TimeNs kAtOnce = 20'000'000;

}  // namespace

/// From one raw stamp to another, the short way round where the device's counter wraps.
TimeNs DeviceClock::forward(TimeNs from, TimeNs to) const {
  TimeNs d = to - from;
  if (options_.wrap <= 0) return d;
  d %= options_.wrap;
  if (d > options_.wrap / 2) d -= options_.wrap;
  if (d <= -options_.wrap / 2) d += options_.wrap;
  return d;
}

TimeNs DeviceClock::map(TimeNs device) const {
  const double line = offset_ns_ + drift_ * static_cast<double>(device - anchor_.device);
  return device + anchor_.residual + static_cast<TimeNs>(std::llround(line));
}

TimeNs DeviceClock::emit(TimeNs t, TimeNs step, TimeNs arrival) {
  if (any_out_) {
    // Where the line moved back, half of the device's step keeps the order and catches up.
    const TimeNs least = last_out_ + options_.min_step;
    const TimeNs wanted = std::max(least, last_out_ + step / 2);
    if (t < wanted) t = std::max(least, std::min(wanted, arrival));
  }
  any_out_ = true;
  last_out_ = t;
  return t;
}

void DeviceClock::start(TimeNs raw, TimeNs device, TimeNs arrival) {
  started_ = true;
  suspects_ = 0;
  sleep_ = 0;
  last_raw_ = raw;
  last_device_ = device;
  points_.clear();
  period_start_ = arrival;
  period_samples_ = 0;
  learn(device, arrival);
}

TimeNs DeviceClock::stamp(TimeNs raw, TimeNs arrival) {
  if (!started_) {
    start(raw, raw, arrival);
    return emit(arrival, 0, arrival);
  }
  const TimeNs step = forward(last_raw_, raw);
  const TimeNs device = last_device_ + step;
  // A wild stamp must not reach the arithmetic below.
  const bool wild = std::abs(step) > std::max(options_.window * 1000, arrival - last_out_) * 2;
  const TimeNs late = wild ? 0 : arrival - map(device);
  if (wild || step < 0 || late < -options_.tolerance || late > options_.max_late) {
    return contradicted(raw, arrival);
  }
  glitches_ += suspects_;
  suspects_ = 0;
  if (sleptToo(arrival, late) && as_late_as_sleep_ < options_.confirmations) {
    last_raw_ = raw;
    last_device_ = device;
    return emit(arrival, 0, arrival);
  }
  if (sleep_ != 0 || shifted(arrival, late)) {
    ++restarts_;
    start(raw, device, arrival);
    return emit(arrival, 0, arrival);
  }
  last_raw_ = raw;
  last_device_ = device;
  learn(device, arrival);
  // Within a bucket the line may lie above a point by what the drift makes of its length.
  return emit(std::min(map(device), arrival), step, arrival);
}

/// A sample that does not belong to the line. Several that belong together are a restart.
TimeNs DeviceClock::contradicted(TimeNs raw, TimeNs arrival) {
  const TimeNs step = forward(suspect_raw_, raw);
  const TimeNs difference = step - (arrival - suspect_arrival_);
  const bool goes_on = suspects_ > 0 && step >= 0 && std::abs(difference) < 5 * options_.tolerance;
  if (!goes_on) {
    glitches_ += suspects_;
    suspects_ = 0;
  }
  ++suspects_;
  suspect_raw_ = raw;
  suspect_arrival_ = arrival;
  if (suspects_ >= options_.confirmations) {
    ++restarts_;
    start(raw, raw, arrival);
  }
  return emit(arrival, 0, arrival);
}

void DeviceClock::hostSlept(TimeNs in_all) {
  // Two clocks are not read at the very same time.
  if (slept_ && in_all - *slept_ > options_.tolerance) {
    sleep_ = in_all - *slept_;
    as_late_as_sleep_ = 0;
  }
  slept_ = in_all;
}

/// Did the device sleep with the host, as far as is known by now?
bool DeviceClock::sleptToo(TimeNs arrival, TimeNs late) {
  if (sleep_ == 0) return false;
  if (late < sleep_ - options_.tolerance) {
    sleep_ = 0;
    return false;
  }
  if (as_late_as_sleep_ == 0) woken_ = arrival;
  if (as_late_as_sleep_ == 0 || arrival - woken_ > kAtOnce) ++as_late_as_sleep_;
  return true;
}

/// True when for a whole period nothing came even nearly in time: a clock was set.
bool DeviceClock::shifted(TimeNs arrival, TimeNs late) {
  if (period_samples_ == 0 || late < period_least_late_) period_least_late_ = late;
  ++period_samples_;
  if (arrival - period_start_ < options_.shift_after) return false;
  const bool shifted =
      period_samples_ >= kFewestInPeriod && period_least_late_ > options_.tolerance;
  period_start_ = arrival;
  period_samples_ = 0;
  return shifted;
}

void DeviceClock::learn(TimeNs device, TimeNs arrival) {
  const Point p{device, arrival - device};
  const bool same_bucket =
      !points_.empty() && points_.back().device / options_.bucket == device / options_.bucket;
  if (!same_bucket) {
    points_.push_back(p);
    while (points_.front().device < device - options_.window) points_.pop_front();
  } else if (p.residual < points_.back().residual) {
    points_.back() = p;
  } else {
    return;
  }
  fit();
}

/// Slope of the lower convex hull's edge over the mean of the abscissas.
double DeviceClock::hullSlope() const {
  struct Vertex {
    double x, y;
  };
  std::vector<Vertex> hull;
  double mean = 0;
  for (const Point& p : points_) {
    const Vertex v{static_cast<double>(p.device - anchor_.device),
                   static_cast<double>(p.residual - anchor_.residual)};
    mean += v.x / static_cast<double>(points_.size());
    while (hull.size() >= 2) {
      const Vertex &a = hull[hull.size() - 2], &b = hull.back();
      if ((b.x - a.x) * (v.y - a.y) > (b.y - a.y) * (v.x - a.x)) break;  // b is below the line a-v
      hull.pop_back();
    }
    hull.push_back(v);
  }
  for (std::size_t i = 1; i < hull.size(); ++i) {
    if (hull[i].x < mean && i + 1 < hull.size()) continue;
    const double dx = hull[i].x - hull[i - 1].x;
    return dx > 0 ? (hull[i].y - hull[i - 1].y) / dx : drift_;
  }
  return drift_;
}

void DeviceClock::fit() {
  anchor_ = points_.front();
  if (points_.back().device - points_.front().device >= options_.drift_after) {
    const double limit = options_.max_drift_ppm * 1e-6;
    drift_ = std::clamp(hullSlope(), -limit, limit);
    drift_known_ = true;
  }
  offset_ns_ = 0;
  for (const Point& p : points_) {
    const double above = static_cast<double>(p.residual - anchor_.residual) -
                         drift_ * static_cast<double>(p.device - anchor_.device);
    offset_ns_ = std::min(offset_ns_, above);
  }
}

}  // namespace core
}  // namespace vir
