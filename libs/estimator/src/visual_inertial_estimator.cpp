#include <algorithm>
#include <cmath>

#include "estimator_impl.h"

namespace vir {

void describe(OptionVisitor& v, FailureOptions& o) {
  v.section("Failure", "When the estimator gives up and starts a new segment");
  v.value("max_blind_s", o.max_blind_s, {0.1, 1e6}, "longest time on the IMU alone");
  v.value("max_speed_mps", o.max_speed_mps, {0.1, 1e6}, "fastest plausible motion");
  v.value("max_bias_acc", o.max_bias_acc, {0.01, 100.0}, "largest plausible bias [m/s^2]");
  v.value("max_bias_gyro", o.max_bias_gyro, {0.001, 100.0}, "largest plausible bias [rad/s]");
}

void describe(OptionVisitor& v, EstimatorConfig& o) {
  describe(v, o.imu);
  describe(v, o.tracker);
  describe(v, o.startup);
  describe(v, o.window);
  describe(v, o.long_window);
  describe(v, o.ranges);
  describe(v, o.rest);
  describe(v, o.failure);
  v.section("Camera", "What the recording does not say about the camera");
  v.value("time_offset_s", o.camera_time_offset_s, {-10.0, 10.0},
          "image stamp + offset = IMU clock");
}

void VisualInertialEstimator::Impl::setCamera(const CameraCalibration& calibration,
                                              const Pose& extrinsics) {
  const auto camera = makeCamera(calibration);
  T_B_C = extrinsics;
  const double focal = 0.5 * (calibration.fx + calibration.fy);
  tracker = std::make_unique<FeatureTracker>(config.tracker, camera);
  startup = std::make_unique<Startup>(config.startup, config.imu, T_B_C, focal);
  window = std::make_unique<ShortWindow>(config.window, config.imu, T_B_C, focal,
                                         config.camera_time_offset_s);
  window->attach(&long_window);
}

void VisualInertialEstimator::Impl::process(const WaitingImage& image) {
  FrameEstimate out;
  out.t = image.t;
  const TimeNs t = image.t + fromSeconds(config.camera_time_offset_s);
  {
    StageTimer total(&out.ms_total);
    if (imu.empty() || t < imu.firstTime()) {
      ++counters.images_without_imu;
      out.health = "no IMU readings yet";
    } else if (missesImu(t)) {
      ++counters.images_without_imu;
      out.health = "no IMU readings";
      if (running) {
        origin = window->newest().T_W_B;
        restart("the IMU was silent");
      }
    } else {
      const double since = any_image ? toSeconds(t - last_image) : 0;
      if (since > kImageGapS) {
        ++counters.image_gaps;
        warn("no image for " + std::to_string(since) + " s before " + std::to_string(image.t) +
             " ns: bridged by the IMU");
      }
      const TrackedFrame frame = track(t, image, &out);
      rest.update(frame, imu);
      if (running) {
        update(frame, &out);
      } else {
        tryStart(frame, &out);
        wait_reasons[out.health] += since;
      }
      any_image = true;
      last_image = t;
      if (frame.usable) last_usable = t;
      dropOldReadings();
    }
  }
  out.segment = segment;
  results.push_back(out);
}

Mat3 VisualInertialEstimator::Impl::rotationSince(TimeNs t0, TimeNs t) {
  if (t0 <= 0 || t <= t0) return Mat3::Identity();
  const Vec3 bg = running ? window->newest().bg : startup->gyroBias();
  const Preintegration p = imu.integrate(t0, t, config.imu, bg, Vec3::Zero());
  return (T_B_C.q.conjugate() * p.dq() * T_B_C.q).toRotationMatrix();
}

TrackedFrame VisualInertialEstimator::Impl::track(TimeNs t, const WaitingImage& image,
                                                  FrameEstimate* out) {
  TrackedFrame frame;
  if (image.tracks) {
    frame = *image.tracks;
    frame.t = t;
  } else {
    frame = tracker->process(t, image.gray, rotationSince(last_usable, t));
  }
  if (!frame.usable) ++counters.images_unusable;
  if (!frame.usable && !in_dark) {
    warn("images from " + std::to_string(t) + " ns on cannot be used: " + frame.reason);
  }
  in_dark = !frame.usable;
  out->tracks = static_cast<int>(frame.features.size());
  pixels.clear();
  for (const FeatureObservation& f : frame.features) pixels.emplace_back(f.px.cast<float>());
  out->ms_pyramid = frame.ms_pyramid;
  out->ms_flow = frame.ms_flow;
  out->ms_detect = frame.ms_detect;
  return frame;
}

void VisualInertialEstimator::Impl::tryStart(const TrackedFrame& frame, FrameEstimate* out) {
  StageTimer timer(&out->ms_start);
  const StartupStatus status = startup->offer(frame, imu, rest, origin, window.get());
  if (status == StartupStatus::waiting) {
    out->health = startup->reason();
    if (!startup->detail().empty()) {
      log(log_sink, LogLevel::debug, "start refused (" + out->health + "): " + startup->detail());
    }
    return;
  }
  log(log_sink, LogLevel::info,
      std::string("started ") +
          (status == StartupStatus::started_standing ? "standing still" : "in motion") +
          (startup->detail().empty() ? "" : ": " + startup->detail()));
  startup->reset();
  running = true;
  last_seen = frame.t;
  startLongWindow();
  window->updateCovariance();
  out->valid = true;
  out->state = inWorld(window->newest());
  out->covariance = covarianceInWorld();
  out->keyframe = true;
  window->slide(true);
  out->landmarks = window->landmarksInNewest();
  out->standing = rest.standing();
  out->health = out->standing ? "standing" : "ok";
}

void VisualInertialEstimator::Impl::update(const TrackedFrame& frame, FrameEstimate* out) {
  const NavState previous = window->newest();
  const TimeNs t = frame.t;
  bool gap = false;
  Preintegration link = imu.integrate(previous.t, t, config.imu, previous.bg, previous.ba, &gap);
  if (gap) ++counters.imu_gaps;
  if (gap && !in_gap) {
    warn("IMU readings missing before " + std::to_string(t) + " ns: bridged, position uncertain");
  }
  in_gap = gap;
  const NavState predicted = predict(previous, link, config.imu.gravity_mps2, t);
  window->push(predicted, std::move(link), frame.features, rest.standing());
  attachRanges(previous, predicted);
  SolveSummary solve;
  {
    StageTimer timer(&out->ms_optimise);
    out->keyframe = window->newestIsKeyframe();
    window->triangulate();
    const bool full = out->keyframe || window->newestEndsRestLink();
    solve = full || config.window.full_every_image
                ? window->optimise(config.window.iterations)
                : window->optimiseNewest(config.window.iterations_newest);
    tracker->drop(window->rejectOutliers());
    if (full && solve.usable) updateAnchors(t);
  }
  out->reprojection_rms = solve.reprojection_rms;
  out->landmarks = window->landmarksInNewest();
  const std::string problem = failure(frame, solve, t);
  if (!problem.empty()) {
    // Carry on from where the readings say it is: better than anything that failed.
    origin = predicted.T_W_B;
    restart(problem);
    out->health = "restarted: " + problem;
    return;
  }
  out->state = inWorld(window->newest());
  out->covariance = covarianceInWorld();
  out->valid = true;
  out->standing = rest.standing();
  const bool blind = t != last_seen;
  out->health = out->standing ? "standing" : (blind ? "no landmarks, IMU only" : "ok");
  {
    StageTimer timer(&out->ms_marginalise);
    window->slide(out->keyframe);
  }
  collectRetired();
}

std::string VisualInertialEstimator::Impl::failure(const TrackedFrame& frame,
                                                   const SolveSummary& solve, TimeNs t) {
  if (!solve.usable) return "the solver found no finite solution";
  const NavState s = window->newest();
  if (window->landmarksInNewest() >= 4 || rest.standing()) last_seen = t;
  if (toSeconds(t - last_seen) > config.failure.max_blind_s) {
    return frame.usable ? "no landmarks for too long" : "no usable image for too long";
  }
  if (s.v.norm() > config.failure.max_speed_mps) return "implausible speed";
  if (s.ba.norm() > config.failure.max_bias_acc) return "implausible accelerometer bias";
  if (s.bg.norm() > config.failure.max_bias_gyro) return "implausible gyro bias";
  return {};
}

void VisualInertialEstimator::Impl::restart(const std::string& why) {
  ++segment;
  ++resets;
  warn("segment " + std::to_string(segment) + " starts at " + std::to_string(last_image) +
       " ns: " + why);
  window->handOver();
  collectRetired();
  window->clear();
  startup->reset();
  tracker->reset();
  rest.reset();
  running = false;
  last_usable = 0;  // nothing left to be matched against
}

VisualInertialEstimator::VisualInertialEstimator(const EstimatorConfig& config, LogSink log)
    : impl_(std::make_unique<Impl>(config, std::move(log))) {}
VisualInertialEstimator::~VisualInertialEstimator() = default;

void VisualInertialEstimator::setCamera(const CameraCalibration& calibration, const Pose& T_B_C) {
  impl_->setCamera(calibration, T_B_C);
}
bool VisualInertialEstimator::hasCamera() const { return impl_->tracker != nullptr; }

const std::vector<Eigen::Vector2f>& VisualInertialEstimator::trackedPixels() const {
  return impl_->pixels;
}

std::vector<FrameEstimate> VisualInertialEstimator::take() {
  return std::exchange(impl_->results, {});
}

const EstimatorCounters& VisualInertialEstimator::counters() const { return impl_->counters; }
const ImuBufferCounters& VisualInertialEstimator::imuCounters() const {
  return impl_->imu.counters();
}
double VisualInertialEstimator::timeOffset() const {
  return impl_->window ? impl_->window->timeOffset() : impl_->config.camera_time_offset_s;
}
Pose VisualInertialEstimator::extrinsics() const {
  return impl_->window ? impl_->window->extrinsics() : impl_->T_B_C;
}
int VisualInertialEstimator::resets() const { return impl_->resets; }
const std::vector<std::string>& VisualInertialEstimator::warnings() const {
  return impl_->warnings;
}

std::string VisualInertialEstimator::longestWaitReason() const {
  std::string best;
  double longest = 0;
  for (const auto& [reason, seconds] : impl_->wait_reasons) {
    if (!reason.empty() && seconds > longest) {
      longest = seconds;
      best = reason;
    }
  }
  return best;
}

}  // namespace vir
