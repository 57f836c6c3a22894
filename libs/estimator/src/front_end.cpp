#include "front_end.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "vir/core/stage_timer.h"

namespace vir::estimator {
namespace {

/// Without an image for longer, the tracks are not expected to survive.
constexpr double kImageGapS = 0.5;
/// Images that wait for readings beyond this many are processed with what there is.
constexpr std::size_t kMaxWaitingImages = 100;
/// An interval between readings that counts as a gap, and the longest that can be bridged by
/// interpolation: measured on the rendered flight, 1.0 s costs nothing, 1.5 s metres.
constexpr double kImuGapS = 0.05, kImuBridgeS = 4.0;
/// This many readings in a row from the past: the clock was set back, not a late packet.
constexpr long kClockStepReadings = 50;

}  // namespace

FrontEnd::FrontEnd(const EstimatorConfig& config, std::function<Feedback(long*)> ask,
                   std::function<void(Packet)> send)
    : config_(config),
      ask_(std::move(ask)),
      send_(std::move(send)),
      imu_(kImuGapS, kImuBridgeS),
      time_offset_s_(config.camera_time_offset_s) {}

void FrontEnd::setCamera(const CameraCalibration& calibration, const Pose& T_B_C) {
  T_B_C_ = T_B_C;
  tracker_ =
      std::make_unique<vision::FeatureTracker>(config_.tracker, camera::makeCamera(calibration));
}

int FrontEnd::addCamera(const CameraMount& mount) {
  if (any_image_ || !waiting_.empty()) {
    throw std::logic_error("VisualInertialEstimator: addCamera after the first image");
  }
  camera::makeCamera(mount.camera);  // throws for one that cannot be
  further_.push_back(mount);
  counters_.further.emplace_back();
  return static_cast<int>(further_.size());
}

TimeNs FrontEnd::onImuClock(TimeNs stamp) const { return stamp + fromSeconds(time_offset_s_); }

void FrontEnd::addImage(WaitingImage image) {
  if (image.camera > 0) {
    ++counters_.further[static_cast<std::size_t>(image.camera) - 1].images;
    return;
  }
  ++counters_.images;
  const TimeNs t = onImuClock(image.t);
  const bool after_waiting = waiting_.empty() || image.t > waiting_.back().t;
  if (!after_waiting || (any_image_ && t <= last_image_)) {
    ++counters_.images_out_of_order;
    return;
  }
  elapsed_.begin(t);
  if (waiting_.empty() && imu_.covers(t)) {
    process(image);
    return;
  }
  if (!image.gray.empty()) image.gray = image.gray.clone();  // the caller's pixels do not last
  waiting_.push_back(std::move(image));
  processWaiting(false);
}

void FrontEnd::addImu(const ImuSample& sample) {
  for (const ImuSample& s : spikes_.add(sample)) takeImu(s);
  counters_.imu_spikes = spikes_.spikes();
  counters_.imu_impossible = spikes_.impossible();
}

void FrontEnd::takeImu(const ImuSample& sample) {
  if (imu_.add(sample)) {
    next_.readings.push_back(sample);
    counters_.imu_gaps = imu_.counters().holes;
    stepped_back_ = 0;
    processWaiting(false);
    return;
  }
  if (imu_.empty() || sample.t > imu_.lastTime()) return;
  if (++stepped_back_ >= kClockStepReadings) clockSetBack(sample);
}

void FrontEnd::clockSetBack(const ImuSample& sample) {
  ++counters_.clock_steps;
  stepped_back_ = 0;
  counters_.images_without_imu += static_cast<long>(waiting_.size());
  for (const WaitingImage& image : waiting_) sendOn(Packet::Kind::lost, image.t);
  waiting_.clear();
  sendOn(Packet::Kind::clock_set_back, 0);
  imu_.clear();
  spikes_.restart();
  any_image_ = false;
  last_image_ = last_usable_ = 0;
  imu_.add(sample);
  next_.readings.push_back(sample);
}

void FrontEnd::finish() {
  processWaiting(true);
  sendOn(Packet::Kind::end, 0);
}

void FrontEnd::processWaiting(bool force) {
  while (!waiting_.empty()) {
    const TimeNs t = onImuClock(waiting_.front().t);
    if (!imu_.covers(t) && !force && waiting_.size() <= kMaxWaitingImages) return;
    process(waiting_.front());
    waiting_.pop_front();
  }
}

bool FrontEnd::missesImu(TimeNs t) const {
  return imu_.inHole(t) || t > imu_.lastTime() + fromSeconds(0.1);
}

void FrontEnd::process(const WaitingImage& image) {
  const TimeNs t = onImuClock(image.t);
  if (imu_.empty() || t < imu_.firstTime()) {
    ++counters_.images_without_imu;
    sendOn(Packet::Kind::before_imu, image.t);
    return;
  }
  if (missesImu(t)) {
    ++counters_.images_without_imu;
    sendOn(Packet::Kind::silent_imu, image.t);
    return;
  }
  next_.since_last_s = any_image_ ? toSeconds(t - last_image_) : 0;
  if (next_.since_last_s > kImageGapS) {
    ++counters_.image_gaps;
    next_.warnings.push_back("no image for " + std::to_string(next_.since_last_s) + " s before " +
                             std::to_string(image.t) + " ns: bridged by the IMU");
  }
  follow(ask_(&next_.feedback));
  const TimeNs now = onImuClock(image.t);  // the feedback may have moved it
  track(now, image);
  any_image_ = true;
  last_image_ = now;
  if (next_.frame.usable) last_usable_ = now;
  imu_.dropBefore(std::min(last_usable_, last_image_) - fromSeconds(kImuHistoryS));
  sendOn(Packet::Kind::image, image.t);
}

void FrontEnd::follow(Feedback feedback) {
  gyro_bias_ = feedback.gyro_bias;
  turning_C_ = feedback.turning_C;
  retime(feedback.time_offset_s);
  if (feedback.q_B_C) T_B_C_.q = *feedback.q_B_C;
  tracker_->stopFollowing(feedback.wrong_tracks);
  if (feedback.resets == resets_) return;
  resets_ = feedback.resets;
  tracker_->reset();
  last_usable_ = 0;  // nothing left to be matched against
}

void FrontEnd::retime(double time_offset_s) {
  if (time_offset_s == time_offset_s_) return;
  const TimeNs by = fromSeconds(time_offset_s) - fromSeconds(time_offset_s_);
  time_offset_s_ = time_offset_s;
  if (any_image_) last_image_ += by;
  if (last_usable_ != 0) last_usable_ += by;
}

Mat3 FrontEnd::rotationSince(TimeNs t0, TimeNs t) {
  if (t0 <= 0 || t <= t0) return Mat3::Identity();
  const imu::Preintegration p = imu_.integrate(t0, t, config_.imu, gyro_bias_, Vec3::Zero());
  return (T_B_C_.q.conjugate() * p.dq() * T_B_C_.q).toRotationMatrix();
}

void FrontEnd::track(TimeNs t, const WaitingImage& image) {
  StageTimer timer(&next_.ms);
  vision::TrackedFrame& frame = next_.frame;
  if (image.tracks) {
    frame = *image.tracks;
    frame.t = t;
  } else {
    frame = turning_C_ ? tracker_->processTurning(t, image.gray, *turning_C_)
                       : tracker_->process(t, image.gray, rotationSince(last_usable_, t));
  }
  next_.tracker_resets = resets_;
  if (!frame.usable) ++counters_.images_unusable;
  if (!frame.usable && !in_dark_) {
    next_.warnings.push_back("images from " + elapsed_.text(t) +
                             " on cannot be used: " + frame.reason);
  }
  in_dark_ = !frame.usable;
}

void FrontEnd::sendOn(Packet::Kind kind, TimeNs stamp) {
  next_.kind = kind;
  next_.stamp = stamp;
  send_(std::exchange(next_, {}));
}

}  // namespace vir::estimator
