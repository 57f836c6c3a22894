#include "camera_timing.h"

#include <algorithm>
#include <cmath>

namespace vir::estimator {
namespace {

/// Turns are kept this long, and taken between images at least this far apart [s].
constexpr double kMemoryS = 4.0, kShortestTurnS = 0.03, kLongestTurnS = 0.3;
/// Squared whitened residuals by which an offset must be better than none.
constexpr double kClearlyBetter = 30;
/// What the start finds by itself, and what a running window does [s].
constexpr double kStartFindsS = 0.003, kWindowFindsS = 0.015;
/// The correlation takes a wrong focal length or moving things for an offset of up to a few of its
/// sigmas: a window that runs well knows better.
constexpr double kSigmasAtStart = 3, kSigmasRunning = 6;
/// Known this well, there is nothing left to look for [s].
constexpr double kKnownS = 0.0015;
constexpr int kImagesPerLook = 2;

}  // namespace

void CameraTiming::reset() {
  last_t_ = 0;
  last_.clear();
  turns_.clear();
}

void CameraTiming::add(const vision::TrackedFrame& frame) {
  if (settled_) return;
  if (!frame.usable) {
    last_t_ = 0;
    return;
  }
  if (last_t_ != 0 && toSeconds(frame.t - last_t_) < kShortestTurnS) return;
  std::vector<initialization::AlignmentSight> sights;
  sights.reserve(frame.features.size());
  for (const vision::FeatureObservation& o : frame.features) sights.push_back({o.id, o.bearing});
  if (last_t_ != 0 && toSeconds(frame.t - last_t_) < kLongestTurnS) {
    const auto turn = initialization::turnBetween(last_t_, last_, frame.t, sights, focal_px_);
    if (turn) turns_.push_back(*turn);
  }
  last_ = std::move(sights);
  last_t_ = frame.t;
  while (!turns_.empty() && toSeconds(frame.t - turns_.front().t0) > kMemoryS) turns_.pop_front();
}

CameraTiming::State CameraTiming::look(const imu::ImuBuffer& imu, const Quat& q_B_C, bool running) {
  if (settled_) return State::agrees;
  if (++since_look_ < kImagesPerLook) return State::open;
  since_look_ = 0;
  found_ = initialization::correlateTurns({turns_.begin(), turns_.end()}, imu, q_B_C);
  if (!found_.ok) return State::open;
  const double least = running ? std::max(kWindowFindsS, kSigmasRunning * found_.sigma_s)
                               : std::max(kStartFindsS, kSigmasAtStart * found_.sigma_s);
  const bool clear = found_.against_none > kClearlyBetter && std::abs(found_.offset_s) > least;
  if (clear) return State::differs;
  if (found_.sigma_s < kKnownS) settled_ = true;
  return State::agrees;
}

void CameraTiming::shift(TimeNs by) {
  if (last_t_ != 0) last_t_ += by;
  for (initialization::ImageTurn& t : turns_) {
    t.t0 += by;
    t.t1 += by;
  }
}

}  // namespace vir::estimator
