#include "vir/imu/spike_filter.h"

#include <algorithm>

namespace vir::imu {
namespace {

/// Beyond any sensor's range, and beyond degrees taken for radians [rad/s], [m/s^2].
constexpr double kMostRate = 300, kMostAcceleration = 4000;
/// So many usual changes from one reading to the next are far, and never less than [rad/s],
/// [m/s^2].
constexpr double kFar = 10, kFarRate = 1, kFarAcceleration = 10;
/// Readings that tell what is usual; until then only what is farther than this is doubted [rad/s],
/// [m/s^2].
constexpr int kLearning = 100;
constexpr double kFarAtFirstRate = 5, kFarAtFirstAcceleration = 50;
/// More readings in a row are no spike, and neither is what comes after a gap [s].
constexpr std::size_t kMostPending = 3;
constexpr double kGapS = 0.05;

/// One change counts for so many usual ones at most.
double moved(double average, double change, double least, int known) {
  const double bounded =
      known < kLearning ? change : std::min(change, 5 * std::max(average, least));
  return average + (bounded - average) / std::min(known + 1, kLearning);
}

}  // namespace

bool SpikeFilter::far(const ImuSample& a, const ImuSample& b, std::size_t between) const {
  const double readings = 1 + static_cast<double>(between);
  const bool known = known_ == kLearning;
  const double least_rate = known ? kFarRate : kFarAtFirstRate;
  const double least_acceleration = known ? kFarAcceleration : kFarAtFirstAcceleration;
  const double rate = readings * std::max(least_rate, kFar * gyro_change_);
  const double acceleration = readings * std::max(least_acceleration, kFar * acc_change_);
  return (a.gyro - b.gyro).norm() > rate || (a.acc - b.acc).norm() > acceleration;
}

void SpikeFilter::accept(const ImuSample& s) {
  if (last_ && s.t > last_->t && toSeconds(s.t - last_->t) < kGapS) {
    gyro_change_ = moved(gyro_change_, (s.gyro - last_->gyro).norm(), 0.1 * kFarRate, known_);
    acc_change_ = moved(acc_change_, (s.acc - last_->acc).norm(), 0.1 * kFarAcceleration, known_);
    known_ = std::min(known_ + 1, kLearning);
  }
  last_ = s;
  accepted_.push_back(s);
}

void SpikeFilter::acceptPending() {
  for (const ImuSample& s : pending_) accept(s);
  pending_.clear();
}

/// Nothing came before, so that only what is far from rest can be doubted: the next ones tell.
void SpikeFilter::begin(const ImuSample& s) {
  const bool doubted = s.gyro.norm() > kFarAtFirstRate || s.acc.norm() > kFarAtFirstAcceleration;
  const bool gap = !pending_.empty() && toSeconds(s.t - pending_.back().t) > kGapS;
  const bool agrees = !pending_.empty() && !far(pending_.back(), s, 0);
  if (doubted && !gap && !agrees && pending_.size() < kMostPending) {
    pending_.push_back(s);
    return;
  }
  if (doubted || gap || agrees) {
    acceptPending();
  } else {
    spikes_ += static_cast<long>(pending_.size());
    pending_.clear();
  }
  accept(s);
}

void SpikeFilter::restart() {
  last_.reset();
  pending_.clear();
}

const std::vector<ImuSample>& SpikeFilter::add(const ImuSample& s) {
  accepted_.clear();
  if (!s.gyro.allFinite() || !s.acc.allFinite() || (last_ && s.t <= last_->t)) {
    accepted_.push_back(s);
    return accepted_;
  }
  if (s.gyro.norm() > kMostRate || s.acc.norm() > kMostAcceleration) {
    ++impossible_;
    return accepted_;
  }
  if (!last_) {
    begin(s);
  } else if (toSeconds(s.t - last_->t) > kGapS) {
    acceptPending();
    accept(s);
  } else if (!far(*last_, s, pending_.size())) {
    spikes_ += static_cast<long>(pending_.size());
    pending_.clear();
    accept(s);
  } else if (pending_.size() == kMostPending ||
             (!pending_.empty() && !far(pending_.back(), s, pending_.size()))) {
    acceptPending();
    accept(s);
  } else {
    pending_.push_back(s);
  }
  return accepted_;
}

}  // namespace vir::imu
