/// What comes in: readings, images and tracks, put into an order the main loop can work on.
#include <algorithm>
#include <stdexcept>

#include "estimator_impl.h"

namespace vir {
namespace {

/// Images that wait for readings beyond this many are processed with what there is.
constexpr std::size_t kMaxWaitingImages = 100;
/// Readings missing for longer cannot be bridged by interpolation: measured on the rendered flight,
/// a hole of 1.0 s costs nothing, one of 1.5 s metres.
constexpr double kImuHoleS = 1.0;
/// This many readings in a row from the past: the clock was set back, not a late packet.
constexpr long kClockStepReadings = 50;
/// Readings kept before the oldest time that may still be asked for [s].
constexpr double kImuHistoryS = 2.0;

}  // namespace

void VisualInertialEstimator::Impl::offer(WaitingImage image) {
  ++counters.images;
  const TimeNs t_imu = image.t + fromSeconds(config.camera_time_offset_s);
  const bool after_waiting = waiting.empty() || image.t > waiting.back().t;
  if (!after_waiting || (any_image && t_imu <= last_image)) {
    ++counters.images_out_of_order;
    return;
  }
  if (waiting.empty() && imu.covers(t_imu)) {
    process(image);
    return;
  }
  if (!image.gray.empty()) image.gray = image.gray.clone();  // the caller's pixels do not last
  waiting.push_back(std::move(image));
  processWaiting(false);
}

void VisualInertialEstimator::Impl::processWaiting(bool force) {
  while (!waiting.empty()) {
    const TimeNs t = waiting.front().t + fromSeconds(config.camera_time_offset_s);
    if (!imu.covers(t) && !force && waiting.size() <= kMaxWaitingImages) return;
    process(waiting.front());
    waiting.pop_front();
  }
}

bool VisualInertialEstimator::Impl::missesImu(TimeNs t) const {
  if (t > hole_start && t < hole_end) return true;
  return t > imu.lastTime() + fromSeconds(0.1);
}

void VisualInertialEstimator::Impl::dropOldReadings() {
  TimeNs oldest = std::min(last_usable, last_image);  // the next image is matched against this one
  if (!running && startup->oldestTime() != 0) oldest = std::min(oldest, startup->oldestTime());
  imu.dropBefore(oldest - fromSeconds(kImuHistoryS));
}

void VisualInertialEstimator::Impl::clockSetBack(const ImuSample& sample) {
  ++counters.clock_steps;
  stepped_back = 0;
  counters.images_without_imu += static_cast<long>(waiting.size());
  for (const WaitingImage& image : waiting) {
    FrameEstimate lost;
    lost.t = image.t;
    lost.segment = segment;
    lost.health = "the clock of the IMU was set back";
    results.push_back(lost);
  }
  waiting.clear();
  if (running) origin = window->newest().T_W_B;
  if (window) restart("the clock of the IMU was set back");
  imu.clear();
  any_image = false;
  last_image = last_usable = 0;
  imu.add(sample);
}

void VisualInertialEstimator::addImu(const ImuSample& sample) {
  Impl& s = *impl_;
  const bool any = !s.imu.empty();
  const TimeNs last = any ? s.imu.lastTime() : 0;
  if (s.imu.add(sample)) {
    if (any && toSeconds(sample.t - last) > kImuHoleS) {
      ++s.counters.imu_gaps;
      s.hole_start = last;
      s.hole_end = sample.t;
    }
    s.stepped_back = 0;
    s.processWaiting(false);
    return;
  }
  if (s.imu.empty() || sample.t > s.imu.lastTime()) return;
  if (++s.stepped_back >= kClockStepReadings) s.clockSetBack(sample);
}

void VisualInertialEstimator::addImage(TimeNs t, const cv::Mat& gray) {
  if (!impl_->tracker) {
    throw std::logic_error("VisualInertialEstimator: setCamera must come before the first image");
  }
  WaitingImage image;
  image.t = t;
  image.gray = gray;
  impl_->offer(std::move(image));
}

void VisualInertialEstimator::addTracks(const TrackedFrame& tracks) {
  if (!impl_->window) {
    throw std::logic_error("VisualInertialEstimator: setCamera must come before the first tracks");
  }
  WaitingImage image;
  image.t = tracks.t;
  image.tracks = std::make_unique<TrackedFrame>(tracks);
  impl_->offer(std::move(image));
}

void VisualInertialEstimator::finish() { impl_->processWaiting(true); }

}  // namespace vir
