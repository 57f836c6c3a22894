#include "front_end.h"

#include <algorithm>
#include <cstdint>
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
  cameras_.clear();
  cameras_.push_back({camera::makeCamera(calibration), T_B_C, 0, false});
  sets_ = ImageSets();
  sets_.addCamera(0);
  counters_.further.clear();
  tracker_.reset();
}

int FrontEnd::addCamera(const CameraMount& mount) {
  if (tracker_ || !waiting_.empty() || counters_.images > 0) {
    throw std::logic_error("VisualInertialEstimator: addCamera after the first image");
  }
  cameras_.push_back({camera::makeCamera(mount.camera), mount.T_B_C, 0, false});
  sets_.addCamera(fromSeconds(mount.time_offset_s) - fromSeconds(time_offset_s_));
  counters_.further.emplace_back();
  return cameras() - 1;
}

vision::RigTracker& FrontEnd::tracker() {
  if (!tracker_) {
    std::vector<vision::RigTracker::Camera> rig;
    for (const Camera& c : cameras_) rig.push_back({c.model, c.T_B_C});
    tracker_ = std::make_unique<vision::RigTracker>(config_.tracker, rig);
  }
  return *tracker_;
}

TimeNs FrontEnd::onImuClock(TimeNs stamp) const { return stamp + fromSeconds(time_offset_s_); }

void FrontEnd::addImage(WaitingImage image) {
  if (cameras() > 1 && !image.tracks) return addOfRig(std::move(image));
  ++counters_.images;
  const TimeNs t = onImuClock(image.t);
  const bool after_waiting = waiting_.empty() || image.t > waiting_.back().t;
  if (!after_waiting || (any_image_ && t <= last_image_)) {
    ++counters_.images_out_of_order;
    return;
  }
  elapsed_.begin(t);
  const bool at_once = waiting_.empty() && imu_.covers(t);
  // The caller's pixels do not last.
  if (!at_once && !image.gray.empty()) image.gray = image.gray.clone();
  image.at = image.t;
  ImageSet set;
  set.t = image.t;
  set.images.push_back(std::move(image));
  if (at_once) return process(set);
  waiting_.push_back(std::move(set));
  processWaiting(false);
}

void FrontEnd::addOfRig(WaitingImage image) {
  const bool first = image.camera == 0;
  const auto number = static_cast<std::size_t>(image.camera);
  ++(first ? counters_.images : counters_.further[number - 1].images);
  elapsed_.begin(onImuClock(image.t));
  if (!image.gray.empty()) image.gray = image.gray.clone();
  if (!sets_.add(std::move(image))) {
    ++(first ? counters_.images_out_of_order : counters_.further[number - 1].out_of_order);
    return;
  }
  takeSets(false);
  processWaiting(false);
}

void FrontEnd::takeSets(bool all) {
  std::vector<long> left_out(cameras_.size());
  while (auto set = sets_.next(all, &left_out)) {
    // The first camera's clock may have been set to where images were worked on already.
    if (any_image_ && onImuClock(set->t) <= last_image_) continue;
    waiting_.push_back(std::move(*set));
  }
  for (std::size_t k = 1; k < left_out.size(); ++k) {
    counters_.further[k - 1].out_of_order += left_out[k];
  }
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
  for (const ImageSet& set : waiting_) sendOn(Packet::Kind::lost, set.t);
  waiting_.clear();
  sets_.clear();
  sendOn(Packet::Kind::clock_set_back, 0);
  imu_.clear();
  spikes_.restart();
  any_image_ = false;
  last_image_ = 0;
  for (Camera& c : cameras_) c.last_usable = 0;
  imu_.add(sample);
  next_.readings.push_back(sample);
}

void FrontEnd::finish() {
  takeSets(true);
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

double FrontEnd::readingsAfterImagesS() const {
  return any_image_ && !imu_.empty() ? std::max(0.0, toSeconds(imu_.lastTime() - last_image_)) : 0;
}

void FrontEnd::process(const ImageSet& set) {
  const TimeNs t = onImuClock(set.t);
  if (imu_.empty() || t < imu_.firstTime()) {
    ++counters_.images_without_imu;
    sendOn(Packet::Kind::before_imu, set.t);
    return;
  }
  if (missesImu(t)) {
    ++counters_.images_without_imu;
    sendOn(Packet::Kind::silent_imu, set.t);
    return;
  }
  next_.since_last_s = any_image_ ? toSeconds(t - last_image_) : 0;
  if (next_.since_last_s > kImageGapS) {
    ++counters_.image_gaps;
    next_.warnings.push_back("no image for " + std::to_string(next_.since_last_s) + " s before " +
                             std::to_string(set.t) + " ns: bridged by the IMU");
  }
  follow(ask_(&next_.feedback));
  const TimeNs now = onImuClock(set.t);  // the feedback may have moved it
  track(now, set);
  any_image_ = true;
  last_image_ = now;
  TimeNs oldest = last_image_;
  for (const Camera& c : cameras_) {
    if (c.last_usable != 0 || cameras() == 1) oldest = std::min(oldest, c.last_usable);
  }
  imu_.dropBefore(oldest - fromSeconds(kImuHistoryS));
  sendOn(Packet::Kind::image, set.t);
}

void FrontEnd::follow(Feedback feedback) {
  gyro_bias_ = feedback.gyro_bias;
  turning_C_ = feedback.turning_C;
  retime(feedback.time_offset_s);
  if (feedback.q_B_C) cameras_.front().T_B_C.q = *feedback.q_B_C;
  if (!feedback.T_B_C.empty()) tracker().setExtrinsics(feedback.T_B_C);
  tracker().stopFollowing(feedback.wrong_tracks);
  if (feedback.resets == resets_) return;
  resets_ = feedback.resets;
  tracker().reset();
  for (Camera& c : cameras_) c.last_usable = 0;  // nothing left to be matched against
}

void FrontEnd::retime(double time_offset_s) {
  if (time_offset_s == time_offset_s_) return;
  const TimeNs by = fromSeconds(time_offset_s) - fromSeconds(time_offset_s_);
  time_offset_s_ = time_offset_s;
  if (any_image_) last_image_ += by;
  for (Camera& c : cameras_) {
    if (c.last_usable != 0) c.last_usable += by;
  }
}

Mat3 FrontEnd::rotationSince(TimeNs t0, TimeNs t, const Quat& q_B_C) {
  if (t0 <= 0 || t <= t0) return Mat3::Identity();
  const imu::Preintegration p = imu_.integrate(t0, t, config_.imu, gyro_bias_, Vec3::Zero());
  return (q_B_C.conjugate() * p.dq() * q_B_C).toRotationMatrix();
}

vision::TrackedFrame FrontEnd::trackAll(TimeNs t, const ImageSet& set) {
  // Without an image for longer, a camera of a rig begins anew: the others hold the pose.
  constexpr double kForgetsS = 2;
  std::vector<vision::RigImage> images;
  for (const WaitingImage& image : set.images) {
    Camera& c = cameras_[static_cast<std::size_t>(image.camera)];
    const TimeNs at = t + (image.at - set.t);
    if (cameras() > 1 && c.last_usable != 0 && toSeconds(at - c.last_usable) > kForgetsS) {
      tracker().reset(image.camera);
      c.last_usable = 0;
    }
    vision::RigImage one;
    one.camera = image.camera;
    one.t = at;
    one.gray = image.gray;
    if (!turning_C_) one.R_C0_C1 = rotationSince(c.last_usable, at, c.T_B_C.q);
    images.push_back(std::move(one));
  }
  std::vector<vision::RigOutcome> outcomes;
  vision::TrackedFrame frame = turning_C_
                                   ? tracker().processTurning(t, images, *turning_C_, &outcomes)
                                   : tracker().process(t, images, &outcomes);
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (outcomes[k].usable) {
      cameras_[static_cast<std::size_t>(images[k].camera)].last_usable = images[k].t;
    }
  }
  noteOutcomes(t, outcomes);
  noteMatches(frame, outcomes);
  next_.epipolar_px = tracker().epipolarPx();
  return frame;
}

void FrontEnd::noteOutcomes(TimeNs t, const std::vector<vision::RigOutcome>& outcomes) {
  const bool first = outcomes.front().camera == 0;
  int usable = 0;
  for (const vision::RigOutcome& o : outcomes) {
    Camera& c = cameras_[static_cast<std::size_t>(o.camera)];
    usable += o.usable;
    if (o.camera > 0) {
      FurtherCameraCounters& of = counters_.further[static_cast<std::size_t>(o.camera) - 1];
      ++(o.usable ? of.taken : of.unusable);
      if (o.usable && !(first && outcomes.front().usable)) ++of.without_partner;
    } else if (!o.usable) {
      ++counters_.images_unusable;
    } else if (cameras() > 1 && outcomes.size() == 1) {
      ++counters_.images_alone;
    }
    if (!o.usable && !c.in_dark) {
      const std::string whose =
          cameras() > 1 ? " of camera " + std::to_string(o.camera) : std::string();
      next_.warnings.push_back("images" + whose + " from " + elapsed_.text(t) +
                               " on cannot be used: " + o.reason);
    }
    c.in_dark = !o.usable;
  }
  next_.cameras = std::max(1, usable);
}

/// How much of what the first camera sees others that should see it were found to see.
void FrontEnd::noteMatches(const vision::TrackedFrame& frame,
                           const std::vector<vision::RigOutcome>& outcomes) {
  if (outcomes.front().camera != 0 || !outcomes.front().usable) return;
  for (std::size_t k = 1; k < outcomes.size(); ++k) {
    const int camera = outcomes[k].camera;
    if (!outcomes[k].usable || !tracker().overlap(0, camera)) continue;
    FurtherCameraCounters& of = counters_.further[static_cast<std::size_t>(camera) - 1];
    of.looked_for += static_cast<long>(frame.features.size());
    const auto seen_by_both = [&](const vision::FeatureObservation& f) {
      const auto at = std::lower_bound(
          frame.features.begin(), frame.features.end(), f.id,
          [](const vision::FeatureObservation& x, std::uint64_t id) { return x.id < id; });
      return f.camera == camera && at != frame.features.end() && at->id == f.id;
    };
    of.matched += std::count_if(frame.further.begin(), frame.further.end(), seen_by_both);
  }
}

void FrontEnd::track(TimeNs t, const ImageSet& set) {
  StageTimer timer(&next_.ms);
  vision::TrackedFrame& frame = next_.frame;
  const WaitingImage& image = set.images.front();
  if (image.tracks) {
    frame = *image.tracks;
    frame.t = t;
    const auto first =
        std::stable_partition(frame.features.begin(), frame.features.end(),
                              [](const vision::FeatureObservation& f) { return f.camera == 0; });
    frame.further.insert(frame.further.end(), first, frame.features.end());
    frame.features.erase(first, frame.features.end());
    if (frame.usable) cameras_.front().last_usable = t;
    std::vector<vision::RigOutcome> outcomes{{0, frame.usable, frame.reason}};
    noteOutcomes(t, outcomes);
  } else {
    frame = trackAll(t, set);
  }
  next_.tracker_resets = resets_;
}

void FrontEnd::sendOn(Packet::Kind kind, TimeNs stamp) {
  next_.kind = kind;
  next_.stamp = stamp;
  send_(std::exchange(next_, {}));
}

}  // namespace vir::estimator
