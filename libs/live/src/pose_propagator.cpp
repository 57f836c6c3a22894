#include "vir/live/pose_propagator.h"

#include <algorithm>

#include "vir/geometry/so3.h"

namespace vir::live {
void PosePropagator::step(const ImuSample& from, const ImuSample& to) {
  const double dt = toSeconds(to.t - from.t);
  const Vec3 w = 0.5 * (from.gyro + to.gyro) - at_.bg;
  const Quat middle = at_.T_W_B.q * expQuat(0.5 * dt * w);
  const Vec3 a = middle * (0.5 * (from.acc + to.acc) - at_.ba) + gravity_W_;
  at_.T_W_B.p += dt * at_.v + 0.5 * dt * dt * a;
  at_.v += dt * a;
  at_.T_W_B.q = (at_.T_W_B.q * expQuat(dt * w)).normalized();
  at_.t = to.t;
}

void PosePropagator::setState(const State& state) {
  const std::lock_guard<std::mutex> lock(mutex_);
  has_state_ = true;
  state_t_ = state.t;
  at_ = state;
  // One reading from before the estimate stays, to interpolate.
  while (samples_.size() > 1 && samples_[1].t <= state.t) samples_.pop_front();
  for (std::size_t i = 1; i < samples_.size(); ++i) {
    if (samples_[i].t <= at_.t) continue;
    const bool inside = samples_[i - 1].t < at_.t;
    step(inside ? interpolated(samples_[i - 1], samples_[i], at_.t) : samples_[i - 1], samples_[i]);
  }
}

void PosePropagator::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  has_state_ = false;
}

std::optional<State> PosePropagator::add(const ImuSample& sample) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!samples_.empty() && sample.t <= samples_.back().t) return std::nullopt;
  samples_.push_back(sample);
  while (samples_.size() > 2 && sample.t - samples_[1].t > 2 * kLongest) samples_.pop_front();
  if (!has_state_ || sample.t <= at_.t || sample.t - state_t_ > kLongest) return std::nullopt;
  if (samples_.size() > 1) {
    const ImuSample& before = samples_[samples_.size() - 2];
    step(before.t < at_.t ? interpolated(before, sample, at_.t) : before, sample);
  }
  return at_;
}

}  // namespace vir::live
