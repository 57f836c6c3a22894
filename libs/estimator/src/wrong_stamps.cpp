/// Images that were not taken when they say: two that have exchanged their stamps, one that comes
/// late out of a buffer, or twice. What they show is where the readings put the camera, at another
/// time; readings that are false put it nowhere near (false_readings.cpp).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "back_end.h"
namespace vir::estimator {
namespace {

/// How far a stamp is looked for, and how finely [s]. Where the robot will be is only known as far
/// as its motion goes on as it does.
constexpr double kEarlierS = 0.3, kLaterS = 0.11, kStepS = 0.005;
/// What motion goes on from [s].
constexpr double kLatelyS = 0.02;
/// So much better another time has to fit, and so well [px]: what was seen before is known exactly
/// (swapped images of MH01 and V1_02: 0.05 to 0.7 px; after false readings: 1.6 to 10 px), what
/// will be seen is not (0.1 to 3 px).
constexpr double kBetter = 2.5, kFitsEarlierPx = 1, kFitsLaterPx = 3;
/// What is left out in a row: with more the clock is another, or the readings are false.
constexpr int kMostInARow = 3;
/// Of the pose that the readings alone give, against the last that sights held.
constexpr double kInflation = 4;

/// Where `newest` is after `s` if its motion goes on as it changed since `before` and `earlier`,
/// which are evenly spaced.
Pose goneOn(const State& earlier, const State& before, const State& newest, double s) {
  const double h = toSeconds(newest.t - before.t);
  const Vec3 turning = logQuat(before.T_W_B.q.conjugate() * newest.T_W_B.q) / h;
  const Vec3 turned = logQuat(earlier.T_W_B.q.conjugate() * before.T_W_B.q) / h;
  const Vec3 faster = (turning - turned) / h;
  const Vec3 acceleration = (newest.v - before.v) / h;
  Pose out;
  out.q = newest.T_W_B.q * expQuat(s * (turning + 0.5 * (s + h) * faster));
  out.p = newest.T_W_B.p + s * newest.v + 0.5 * s * s * acceleration;
  return out;
}

}  // namespace

/// By the readings alone, from the last keyframe before; `newest` is where they lead.
std::optional<Pose> BackEnd::poseByReadings(TimeNs t, const State& newest) {
  const std::vector<State> states = window->states();
  const auto by_readings = [&](TimeNs at) -> std::optional<State> {
    const auto after =
        std::find_if(states.begin(), states.end(), [at](const State& s) { return s.t >= at; });
    if (after != states.end() && after->t == at) return *after;
    if (after == states.begin()) return std::nullopt;
    const State& from = *(after - 1);
    const imu::Preintegration link =
        imu.integrate(from.t, at, imu_noise, from.bg, from.ba, nullptr, window->imuIntrinsics());
    return window::predict(from, link, config.imu.gravity_mps2, at);
  };
  if (t <= newest.t) {
    const std::optional<State> s = by_readings(t);
    return s ? std::optional<Pose>(s->T_W_B) : std::nullopt;
  }
  const TimeNs h = fromSeconds(kLatelyS);
  const auto before = by_readings(newest.t - h), earlier = by_readings(newest.t - 2 * h);
  if (!before || !earlier) return std::nullopt;
  return goneOn(*earlier, *before, newest, toSeconds(t - newest.t));
}

std::optional<double> BackEnd::stampIsOffBy(const vision::TrackedFrame& frame,
                                            const State& predicted, double off_px) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  double best_px = off_px / kBetter;
  std::optional<double> out;
  const int last = static_cast<int>(std::lround(kLaterS / kStepS));
  for (int k = -static_cast<int>(std::lround(kEarlierS / kStepS)); k <= last; ++k) {
    const double by_s = k * kStepS;
    const auto pose = poseByReadings(frame.t + fromSeconds(by_s), predicted);
    if (!pose) continue;
    const double px = window->resect(*pose, frame.features, kAny).predicted.median_px;
    if (px >= std::min(best_px, by_s > 0 ? kFitsLaterPx : kFitsEarlierPx)) continue;
    best_px = px;
    out = by_s;
  }
  return out;
}

bool BackEnd::wronglyStamped(const vision::TrackedFrame& frame, const State& predicted,
                             const std::optional<window::Resected>& seen) {
  if (!seen) wrong_stamps_in_a_row = 0;
  if (!seen || wrong_stamps_in_a_row == kMostInARow) return false;
  const std::optional<double> by_s = stampIsOffBy(frame, predicted, seen->predicted.median_px);
  if (!by_s) return false;
  ++wrong_stamps_in_a_row;
  if (images_misstamped++ > 0) return true;
  char text[200];
  std::snprintf(text, sizeof text,
                "the image of %.3f s shows what was seen %.0f ms %s, by the readings of the IMU: "
                "left out, as are others whose stamps are wrong (images_misstamped counts them)",
                toSeconds(frame.t), 1e3 * std::abs(*by_s), *by_s < 0 ? "earlier" : "later");
  warn(text);
  return true;
}

void BackEnd::noteLateness(double late_s) {
  stamp_jitter.add(late_s);
  window->setStampSigma(stamp_jitter.sigma());
  if (stamp_jitter.sigma() == 0 || jitter_told) return;
  jitter_told = true;
  char text[200];
  std::snprintf(
      text, sizeof text,
      "the stamps of the images are off by about %.0f ms, each by itself, by the readings "
      "of the IMU (from %s): believed accordingly less; stamp them when they are taken",
      1e3 * stamp_jitter.sigma(), elapsed.text(window->newest().t).c_str());
  warn(text);
}

void BackEnd::leaveOut(const State& predicted, StateEstimate* out) const {
  out->state = inWorld(predicted);
  out->covariance = kInflation * covarianceInWorld();
  out->odometry_scale = odometryScale();
  out->calibration = window->calibration();
  out->valid = true;
  out->health = Health::doubtful;
  out->reason = "the image's stamp is wrong: left out";
}

}  // namespace vir::estimator
