#include "vir/imu/imu_buffer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace vir::imu {
namespace {
/// A bridged gap, or motion beyond the sensor's range: the readings in between are a guess, wrong
/// by several m/s^2 and rad/s. With the densities of a usual IMU this factor stands for about 1
/// m/s^2 and 0.1 rad/s over a second.
constexpr double kGapNoiseFactor = 150.0;

bool earlier(const ImuSample& s, TimeNs t) { return s.t < t; }
}  // namespace

bool ImuBuffer::add(const ImuSample& s) {
  if (!s.gyro.allFinite() || !s.acc.allFinite()) {
    ++counters_.not_finite;
    return false;
  }
  if (!samples_.empty() && s.t <= samples_.back().t) {
    ++counters_.out_of_order;
    return false;
  }
  if (!samples_.empty()) {
    const double since_last_s = toSeconds(s.t - samples_.back().t);
    if (since_last_s > max_gap_s_) ++counters_.gaps;
    if (since_last_s > max_bridge_s_) ++counters_.holes;
  }
  ++counters_.accepted;
  samples_.push_back(s);
  if (const auto begin = saturation_.add(s)) {
    if (saturated_.empty() || saturated_.back().last < *begin) saturated_.push_back({*begin, s.t});
    saturated_.back().last = s.t;
  }
  return true;
}

bool ImuBuffer::isSaturated(TimeNs t0, TimeNs t1) const {
  return std::any_of(saturated_.begin(), saturated_.end(),
                     [&](const Stretch& s) { return s.first <= t1 && s.last >= t0; });
}

bool ImuBuffer::inHole(TimeNs t) const {
  const auto next = std::lower_bound(samples_.begin(), samples_.end(), t, earlier);
  if (next == samples_.begin() || next == samples_.end() || next->t == t) return false;
  return toSeconds(next->t - (next - 1)->t) > max_bridge_s_;
}

ImuSample ImuBuffer::at(TimeNs t) const {
  const auto it = std::lower_bound(samples_.begin(), samples_.end(), t, earlier);
  ImuSample out;
  if (it == samples_.end()) {
    out = samples_.back();
  } else if (it == samples_.begin() || it->t == t) {
    out = *it;
  } else {
    out = interpolated(*(it - 1), *it, t);
  }
  out.t = t;
  return out;
}

Preintegration ImuBuffer::integrate(TimeNs t0, TimeNs t1, const ImuNoise& noise,
                                    const Vec3& bias_gyro, const Vec3& bias_acc, bool* gap,
                                    const ImuIntrinsics& intrinsics) {
  if (t1 <= t0 || samples_.empty()) {
    throw std::invalid_argument("ImuBuffer::integrate: needs readings and t0 < t1");
  }
  Preintegration out(noise, bias_gyro, bias_acc, intrinsics);
  bool any_gap = false;
  ImuSample prev = at(t0);
  auto it = std::lower_bound(samples_.begin(), samples_.end(), t0 + 1, earlier);
  // Is a stretch of this length covered by readings on both sides?
  const auto factor = [&](const ImuSample& a, const ImuSample& b) {
    const bool outside = a.t < samples_.front().t || b.t > samples_.back().t;
    const bool wide = [&] {
      const auto hi = std::lower_bound(samples_.begin(), samples_.end(), b.t, earlier);
      if (hi == samples_.begin() || hi == samples_.end()) return false;
      return toSeconds(hi->t - (hi - 1)->t) > max_gap_s_;
    }();
    const bool is_gap = wide || (outside && toSeconds(b.t - a.t) > max_gap_s_);
    any_gap = any_gap || is_gap;
    return is_gap || isSaturated(a.t, b.t) ? kGapNoiseFactor : 1.0;
  };
  for (; it != samples_.end() && it->t < t1; ++it) {
    out.integrate(prev, *it, factor(prev, *it));
    prev = *it;
  }
  const ImuSample last = at(t1);
  out.integrate(prev, last, factor(prev, last));
  if (gap) *gap = any_gap;
  return out;
}

bool ImuBuffer::statistics(TimeNs t0, TimeNs t1, Vec3* gyro_mean, Vec3* acc_mean, double* gyro_std,
                           double* acc_std) const {
  const auto lo = std::lower_bound(samples_.begin(), samples_.end(), t0, earlier);
  Vec3 gm = Vec3::Zero(), am = Vec3::Zero();
  int n = 0;
  for (auto it = lo; it != samples_.end() && it->t <= t1; ++it, ++n) {
    gm += it->gyro;
    am += it->acc;
  }
  if (n < 3) return false;
  gm /= n;
  am /= n;
  double gv = 0, av = 0;
  for (auto it = lo; it != samples_.end() && it->t <= t1; ++it) {
    gv += (it->gyro - gm).squaredNorm();
    av += (it->acc - am).squaredNorm();
  }
  *gyro_mean = gm;
  *acc_mean = am;
  *gyro_std = std::sqrt(gv / n);
  *acc_std = std::sqrt(av / n);
  return true;
}

double ImuBuffer::rate(TimeNs t0, TimeNs t1) const {
  if (t1 <= t0) return 0;
  const auto lo = std::lower_bound(samples_.begin(), samples_.end(), t0, earlier);
  const auto hi = std::lower_bound(lo, samples_.end(), t1, earlier);
  return static_cast<double>(hi - lo) / toSeconds(t1 - t0);
}

bool ImuBuffer::meanGyro(TimeNs t0, TimeNs t1, Vec3* rate) const {
  if (samples_.empty() || t1 <= t0 || t0 < samples_.front().t || t1 > samples_.back().t) {
    return false;
  }
  // The trapezoidal rule over the readings inside and the interpolated ends.
  ImuSample before = at(t0);
  rate->setZero();
  auto it = std::lower_bound(samples_.begin(), samples_.end(), t0 + 1, earlier);
  for (; it != samples_.end() && it->t < t1; ++it) {
    *rate += 0.5 * toSeconds(it->t - before.t) * (before.gyro + it->gyro);
    before = *it;
  }
  const ImuSample last = at(t1);
  *rate += 0.5 * toSeconds(t1 - before.t) * (before.gyro + last.gyro);
  *rate /= toSeconds(t1 - t0);
  return true;
}

void ImuBuffer::dropBefore(TimeNs t) {
  while (samples_.size() > 1 && samples_[1].t <= t) samples_.pop_front();
  while (!saturated_.empty() && saturated_.front().last < samples_.front().t) {
    saturated_.pop_front();
  }
}

}  // namespace vir::imu
