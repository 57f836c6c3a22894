/// The camera's clock against the IMU's: where the back end follows what is found of it.
#include <algorithm>
#include <cmath>

#include "back_end.h"

namespace vir::estimator {
namespace {

/// Readings may end this long before an image: held for that time [s].
constexpr double kUncoveredS = 0.02;
/// The stamps follow the window's offset by this share of the time between images at most.
constexpr double kFollow = 0.2;
/// Poses kept for a start that has to be made anew [s].
constexpr double kRecentS = 2.5;

std::string milliseconds(double s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f ms", 1e3 * s);
  return text;
}

}  // namespace

bool BackEnd::putOnImuClock(Packet* packet) {
  if (running && config.window.calibrate) {
    const TimeNs newest = window->newest().t;
    const double since = toSeconds(packet->stamp - newest) + time_offset_s;
    const double most = kFollow * std::max(0.0, since);
    time_offset_s += std::clamp(window->timeOffset() - time_offset_s, -most, most);
    window->stampWith(time_offset_s);
  }
  packet->frame.t = packet->stamp + fromSeconds(time_offset_s);
  return coveredByReadings(packet->frame.t);
}

bool BackEnd::coveredByReadings(TimeNs t) const {
  return imu.lastTime() + fromSeconds(kUncoveredS) >= t;
}

bool BackEnd::checkTiming(const vision::TrackedFrame& frame) {
  if (!timing) return false;
  timing->add(frame);
  const bool all_known = timing->offsetKnown() && timing->rotationKnown();
  if (running && !all_known) rememberPose(window->newest());
  if (timing->offsetKnown()) return false;
  if (running) startup->remember(frame);
  if (timing->look(imu, window->extrinsics().q, running) != CameraTiming::State::differs)
    return false;
  const double by = timing->found().offset_s;
  tellTiming(by);
  retime(by);
  if (!running) return false;
  // What was estimated since the motion began was estimated with the wrong times.
  const TimeNs begin = startup->oldestTime();
  const auto at = std::lower_bound(recent.begin(), recent.end(), begin,
                                   [](const StampedPose& p, TimeNs t) { return p.t < t; });
  if (at != recent.end()) origin = at->T_W_B;
  window->clear();
  if (long_window.anchors().empty()) long_window.clear();  // W is O still
  running = false;
  return true;
}

void BackEnd::tellTiming(double by_s) {
  warn("the images seem " + milliseconds(std::abs(by_s)) + (by_s < 0 ? " late" : " early") +
       " against the IMU (+-" + milliseconds(timing->found().sigma_s) +
       "): taken into account; camera time offset " + milliseconds(time_offset_s + by_s));
}

void BackEnd::rememberPose(const State& s) {
  recent.push_back({s.t, s.T_W_B});
  while (toSeconds(recent.back().t - recent.front().t) > kRecentS) recent.pop_front();
}

void BackEnd::retime(double by_s) {
  startup->shift(fromSeconds(by_s));
  shiftTimes(by_s);
  window->setTimeOffset(time_offset_s, timeOffsetSigma());
}

void BackEnd::shiftTimes(double by_s) {
  if (by_s == 0) return;
  const TimeNs by = fromSeconds(by_s);
  time_offset_s += by_s;
  timing->shift(by);
  rest.reset();
  for (StampedPose& p : recent) p.t += by;
}

double BackEnd::timeOffsetSigma() const {
  constexpr double kUnknownS = 0.03;
  if (!timing) return 0;
  const double least = config.window.calibration.time_offset_s;
  if (!timing->found().ok) return std::max(least, kUnknownS);
  return std::max(least, 3 * timing->found().sigma_s);
}

}  // namespace vir::estimator
