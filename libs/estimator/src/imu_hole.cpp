/// Where readings are missing for longer the images alone say how the body moves.
#include "back_end.h"
#include "vir/initialization/image_turn.h"

namespace vir::estimator {
namespace {

/// A hole for shorter is bridged by the interpolated readings [s].
constexpr double kHoleS = 0.3;
/// With the readings back, the landmarks must be so after as long [s].
constexpr double kSeesAgainS = 0.5;
constexpr double kShareSeenAgain = 0.12;
constexpr std::size_t kTracksThatCount = 30;

}  // namespace

void BackEnd::rememberSights(const vision::TrackedFrame& frame) {
  last_sights.t = frame.t;
  last_sights.of.clear();
  for (const vision::FeatureObservation& o : frame.features) {
    last_sights.of.push_back({o.id, o.bearing});
  }
}

void BackEnd::noteHole(bool gap, TimeNs previous, TimeNs t) {
  if (gap) {
    ++imu_gaps;
    if (!in_gap) {
      warn("IMU readings missing before " + elapsed.text(t) + ": bridged, position uncertain");
      hole.from = previous;
    }
    hole.to = t;
  }
  in_gap = gap;
}

/// Interpolated readings may be wrong by radians per second, and sights that a guess puts far away
/// are left out as wrong: the tracks tell how the camera turned. The velocity is as it was.
void BackEnd::guessAcrossHole(const State& previous, const vision::TrackedFrame& frame,
                              State* predicted) const {
  const double dt = toSeconds(frame.t - previous.t);
  predicted->v = previous.v;
  predicted->T_W_B.p = previous.T_W_B.p + dt * previous.v;
  if (last_sights.t != previous.t) return;
  std::vector<initialization::AlignmentSight> now;
  for (const vision::FeatureObservation& o : frame.features) now.push_back({o.id, o.bearing});
  const auto turn =
      initialization::turnBetween(previous.t, last_sights.of, frame.t, now, focalPx());
  if (!turn) return;
  const Quat q_B_C = window->extrinsics().q;
  predicted->T_W_B.q = (previous.T_W_B.q * expQuat(q_B_C * (dt * turn->rate_C))).normalized();
}

bool BackEnd::lostInHole(const vision::TrackedFrame& frame, TimeNs t) {
  if (hole.to == 0 || toSeconds(t - hole.to) < kSeesAgainS) return false;
  const bool was_long = toSeconds(hole.to - hole.from) > kHoleS;
  hole = {};
  const std::size_t tracks = frame.features.size();
  return was_long && tracks >= kTracksThatCount && !rest.standing() &&
         window->landmarksInNewest() < kShareSeenAgain * static_cast<double>(tracks);
}

}  // namespace vir::estimator
