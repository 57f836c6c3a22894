#include "imu_pairing.h"

namespace vir {
namespace {

constexpr std::size_t kMostWaiting = 20'000;

}  // namespace

void ImuPairing::addAccelerometer(const TimedVector& v) {
  if (!acc_.empty() && v.t <= acc_.back().t) {
    ++dropped_;
    return;
  }
  acc_.push_back(v);
  if (acc_.size() > kMostWaiting) acc_.pop_front();
  pair();
}

void ImuPairing::addGyro(const TimedVector& v) {
  if (!gyro_.empty() && v.t <= gyro_.back().t) {
    ++dropped_;
    return;
  }
  gyro_.push_back(v);
  if (gyro_.size() > kMostWaiting) {
    gyro_.pop_front();
    ++dropped_;
  }
  pair();
}

void ImuPairing::pair() {
  while (!gyro_.empty()) {
    const TimedVector& g = gyro_.front();
    while (acc_.size() >= 2 && acc_[1].t <= g.t) acc_.pop_front();
    if (acc_.empty()) return;
    if (acc_.front().t > g.t) {  // nothing before it
      ++dropped_;
      gyro_.pop_front();
      continue;
    }
    const bool exact = acc_.front().t == g.t;
    if (!exact && acc_.size() < 2) return;
    const TimedVector& a = acc_.front();
    const TimedVector& b = exact ? a : acc_[1];
    if (b.t - a.t > kLongestGap) {
      ++dropped_;
    } else {
      const double u = exact ? 0 : static_cast<double>(g.t - a.t) / static_cast<double>(b.t - a.t);
      ready_.push_back({g.t, g.v, a.v + u * (b.v - a.v)});
    }
    gyro_.pop_front();
  }
}

std::vector<ImuSample> ImuPairing::take() {
  std::vector<ImuSample> out;
  out.swap(ready_);
  return out;
}

}  // namespace vir
