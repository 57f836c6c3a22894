/// Readings of the IMU that cannot be, in a row: a loose plug, a radio beside it, a buffer read
/// twice. Where many landmarks agree on a pose that the readings miss by far, the images are right.
#include <algorithm>
#include <cstdio>
#include <limits>

#include "back_end.h"
#include "vir/core/order_statistics.h"

namespace vir::estimator {
namespace {

/// Sights lie this far from where the readings put them [px], so much further than lately, and fit
/// another pose so much better. Of good recordings none was further off than 0.9
/// (docs/decisions.md).
constexpr double kFarPx = 1.5, kUsual = 4, kBetter = 2.5;
/// What an image counts in what is usual.
constexpr double kShare = 0.05;
/// So little tracks move in an image that shows what the one before showed [px].
constexpr double kStillPx = 0.7;
constexpr int kSightsThatCount = 20;
/// Contradicted for longer, it is no burst, and doubted; and for longer than an IMU is missed,
/// calibration, clock or images are wrong as likely [s].
constexpr double kBurstS = 0.5, kLongestS = 4;
/// Hardly believed: what stands in for the readings is off by metres per second squared.
constexpr double kNoiseFactor = 150;

}  // namespace

/// What moves stands still in the picture: a camera that hangs, a lift.
bool BackEnd::hangs(const State& previous, const vision::TrackedFrame& frame) const {
  std::vector<double> moved_px;
  for (const vision::FeatureObservation& o : frame.features) {
    const auto before = std::lower_bound(
        last_sights.of.begin(), last_sights.of.end(), o.id,
        [](const initialization::AlignmentSight& s, std::uint64_t id) { return s.id < id; });
    if (before == last_sights.of.end() || before->id != o.id) continue;
    moved_px.push_back((o.bearing - before->bearing).norm() * focalPx());
  }
  if (moved_px.empty() || median(std::move(moved_px)) > kStillPx) return false;
  const double dt = toSeconds(frame.t - previous.t);
  Pose steady = previous.T_W_B;
  steady.p += dt * previous.v;
  steady.q = steady.q * expQuat(dt * turning_B);
  constexpr double kAny = std::numeric_limits<double>::infinity();
  return window->resect(steady, allSights(frame), kAny).found.median_px > kFarPx;
}

std::optional<window::Resected> BackEnd::contradiction(const State& previous,
                                                       const vision::TrackedFrame& frame,
                                                       const Pose& predicted) {
  if (rest.standing()) return std::nullopt;
  const double far_px = std::max(kFarPx, kUsual * usual_off_px);
  const window::Resected seen = window->resect(predicted, allSights(frame), far_px);
  if (seen.late_s) noteLateness(*seen.late_s);
  if (seen.found.sights < kSightsThatCount) return std::nullopt;
  const double off_px = seen.predicted.median_px;
  if (off_px < far_px || off_px < kBetter * seen.found.median_px) {
    usual_off_px += kShare * (std::min(off_px, far_px) - usual_off_px);
    return std::nullopt;
  }
  if (hangs(previous, frame)) return std::nullopt;
  return seen;
}

bool BackEnd::contradicted(const State& previous, const vision::TrackedFrame& frame,
                           const std::optional<window::Resected>& seen, State* predicted) {
  if (!seen) {
    contradicted_since = 0;
    return false;
  }
  if (contradicted_since == 0) {
    contradicted_since = frame.t;
    char text[160];
    std::snprintf(text, sizeof text,
                  "readings of the IMU before %s put the sights %.1f px off: left out, bridged "
                  "by the images",
                  elapsed.text(frame.t).c_str(), seen->predicted.median_px);
    warn(text);
  }
  const double since_s = toSeconds(frame.t - contradicted_since);
  if (since_s > kBurstS) {
    doubts.add(
        "contradicted", frame.t,
        "the readings of the IMU contradict the images for more than half a second: a broken "
        "IMU, a wrong calibration or clock");
  }
  if (since_s > kLongestS) return false;
  ++imu_contradicted;
  const double dt = toSeconds(frame.t - previous.t);
  const Quat q_C_B = window->extrinsics().q.conjugate();
  turning_C = q_C_B * Vec3(logQuat(previous.T_W_B.q.conjugate() * seen->T_W_B.q) / dt);
  predicted->T_W_B = seen->T_W_B;
  predicted->v = (seen->T_W_B.p - previous.T_W_B.p) / dt;
  return true;
}

/// As if the IMU had read what the images say.
imu::Preintegration BackEnd::linkBySight(const State& previous, const State& seen) const {
  const double dt = toSeconds(seen.t - previous.t);
  const Vec3 g(0, 0, -config.imu.gravity_mps2);
  ImuSample reading;
  reading.t = previous.t;
  reading.gyro = logQuat(previous.T_W_B.q.conjugate() * seen.T_W_B.q) / dt + previous.bg;
  reading.acc = previous.T_W_B.q.conjugate() * ((seen.v - previous.v) / dt - g) + previous.ba;
  ImuSample last = reading;
  last.t = seen.t;
  imu::Preintegration link(imu_noise, previous.bg, previous.ba, window->imuIntrinsics());
  link.integrate(reading, last, kNoiseFactor);
  return link;
}

}  // namespace vir::estimator
