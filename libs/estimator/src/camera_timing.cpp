#include "camera_timing.h"

#include <algorithm>
#include <cmath>

namespace vir::estimator {
namespace {

/// Turns are kept this long [s].
constexpr double kMemoryS = 4.0;
/// Between the images of a turn [s]: over less, noise makes turns of steps aside; over more, the
/// turning is smoothed away. They overlap: one begins at every image, but no more often than that.
constexpr double kShortestTurnS = 0.09, kLongestTurnS = 0.3, kSpacingS = 0.03;
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
  seen_.clear();
  turns_.clear();
}

void CameraTiming::add(const vision::TrackedFrame& frame) {
  if (offset_known_ && rotation_known_) return;
  if (!frame.usable) {
    seen_.clear();
    return;
  }
  if (!seen_.empty() && toSeconds(frame.t - seen_.back().t) < kSpacingS) return;
  std::vector<initialization::AlignmentSight> sights;
  sights.reserve(frame.features.size());
  for (const vision::FeatureObservation& o : frame.features) sights.push_back({o.id, o.bearing});
  // The latest that is far enough back.
  while (seen_.size() > 1 && toSeconds(frame.t - seen_[1].t) >= kShortestTurnS) seen_.pop_front();
  if (!seen_.empty()) {
    const Seen& from = seen_.front();
    const double span = toSeconds(frame.t - from.t);
    if (span >= kShortestTurnS && span < kLongestTurnS) {
      const auto turn =
          initialization::turnBetween(from.t, from.sights, frame.t, sights, focal_px_);
      if (turn) turns_.push_back(*turn);
    }
  }
  seen_.push_back({frame.t, std::move(sights)});
  while (!turns_.empty() && toSeconds(frame.t - turns_.front().t0) > kMemoryS) turns_.pop_front();
}

CameraTiming::State CameraTiming::look(const imu::ImuBuffer& imu, const Quat& q_B_C, bool running) {
  if (offset_known_) return State::agrees;
  if (++since_look_ < kImagesPerLook) return State::open;
  since_look_ = 0;
  found_ = initialization::correlateTurns({turns_.begin(), turns_.end()}, imu, q_B_C);
  if (!found_.ok) return State::open;
  const double least = running ? std::max(kWindowFindsS, kSigmasRunning * found_.sigma_s)
                               : std::max(kStartFindsS, kSigmasAtStart * found_.sigma_s);
  const bool clear = found_.against_none > kClearlyBetter && std::abs(found_.offset_s) > least;
  if (clear) return State::differs;
  if (found_.sigma_s < kKnownS) offset_known_ = true;
  return State::agrees;
}

bool CameraTiming::suggests() const {
  constexpr double kUncertainS = 0.03;
  return !offset_known_ && std::abs(found_.offset_s) > kStartFindsS && found_.sigma_s > 0 &&
         found_.sigma_s < kUncertainS;
}

void CameraTiming::shift(TimeNs by) {
  for (Seen& s : seen_) s.t += by;
  found_.offset_s -= toSeconds(by);
  for (initialization::ImageTurn& t : turns_) {
    t.t0 += by;
    t.t1 += by;
  }
}

}  // namespace vir::estimator
