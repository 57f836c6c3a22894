#include "vir/estimator/visual_inertial_estimator.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <stdexcept>

namespace vir {
namespace {

/// Images that wait for readings beyond this many are processed with what there is.
constexpr std::size_t kMaxWaitingImages = 100;
/// Without an image for longer, the tracks are not expected to survive.
constexpr double kImageGapS = 0.5;
/// Readings missing for longer cannot be bridged by interpolation: measured on the rendered flight,
/// a hole of 1.0 s costs nothing, one of 1.5 s metres.
constexpr double kImuHoleS = 1.0;
/// This many readings in a row from the past: the clock was set back, not a late packet.
constexpr long kClockStepReadings = 50;

double cpuMs() {
  timespec ts{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &ts);
  return ts.tv_sec * 1e3 + ts.tv_nsec * 1e-6;
}

/// Adds the CPU time of a scope to a counter (reporting only).
class StageTimer {
 public:
  explicit StageTimer(double* ms) : ms_(ms), start_(cpuMs()) {}
  ~StageTimer() { *ms_ += cpuMs() - start_; }

 private:
  double* ms_;
  double start_;
};

}  // namespace

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
  describe(v, o.rest);
  describe(v, o.failure);
  v.section("Camera", "What the recording does not say about the camera");
  v.value("time_offset_s", o.camera_time_offset_s, {-10.0, 10.0},
          "image stamp + offset = IMU clock");
}

struct VisualInertialEstimator::Impl {
  Impl(const EstimatorConfig& c, LogSink l) : config(c), log_sink(std::move(l)), rest(c.rest) {}

  void setCamera(const CameraCalibration& calibration, const Pose& extrinsics);
  void process(TimeNs t_image, const cv::Mat& gray);
  void processWaiting(bool force);
  TrackedFrame track(TimeNs t, const cv::Mat& gray, FrameEstimate* out);
  void tryStart(const TrackedFrame& frame, FrameEstimate* out);
  void update(const TrackedFrame& frame, FrameEstimate* out);
  std::string failure(const TrackedFrame& frame, const SolveSummary& solve, TimeNs t);
  void restart(const std::string& why);
  /// Does t lie in a hole of the readings, or well behind the last of them?
  bool missesImu(TimeNs t) const;
  void collectRetired();
  void warn(const std::string& text) {
    log(log_sink, LogLevel::warning, text);
    warnings.push_back(text);
  }

  EstimatorConfig config;
  LogSink log_sink;
  std::unique_ptr<FeatureTracker> tracker;
  std::unique_ptr<Startup> startup;
  std::unique_ptr<ShortWindow> window;
  Pose T_B_C;
  ImuBuffer imu;
  RestDetector rest;
  std::deque<std::pair<TimeNs, cv::Mat>> waiting;
  std::vector<FrameEstimate> results;
  std::vector<NavState> old_keyframes;
  std::vector<WindowLandmark> old_landmarks;
  std::vector<std::string> warnings;
  std::map<std::string, double> wait_reasons;  // seconds
  EstimatorCounters counters;
  Pose origin;  // where the next segment starts
  bool running = false;
  int segment = 0;
  int resets = 0;
  TimeNs hole_start = 0, hole_end = 0;   // the last long interval without readings
  bool in_gap = false, in_dark = false;  // warn once per stretch
  long stepped_back = 0;
  bool any_image = false;
  TimeNs last_image = 0;  // on the IMU clock
  TimeNs last_usable = 0;
  TimeNs last_seen = 0;  // last time landmarks held the pose
};

void VisualInertialEstimator::Impl::setCamera(const CameraCalibration& calibration,
                                              const Pose& extrinsics) {
  const auto camera = makeCamera(calibration);
  T_B_C = extrinsics;
  const double focal = 0.5 * (calibration.fx + calibration.fy);
  tracker = std::make_unique<FeatureTracker>(config.tracker, camera);
  startup = std::make_unique<Startup>(config.startup, config.imu, T_B_C, focal);
  window = std::make_unique<ShortWindow>(config.window, config.imu, T_B_C, focal,
                                         config.camera_time_offset_s);
}

void VisualInertialEstimator::Impl::processWaiting(bool force) {
  while (!waiting.empty()) {
    const TimeNs t = waiting.front().first + fromSeconds(config.camera_time_offset_s);
    if (!imu.covers(t) && !force && waiting.size() <= kMaxWaitingImages) return;
    process(waiting.front().first, waiting.front().second);
    waiting.pop_front();
  }
}

void VisualInertialEstimator::Impl::process(TimeNs t_image, const cv::Mat& gray) {
  FrameEstimate out;
  out.t = t_image;
  const TimeNs t = t_image + fromSeconds(config.camera_time_offset_s);
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
        warn("no image for " + std::to_string(since) + " s before " + std::to_string(t_image) +
             " ns: bridged by the IMU");
      }
      const TrackedFrame frame = track(t, gray, &out);
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
      imu.dropBefore(running || startup->oldestTime() == 0
                         ? std::min(last_usable, rest.standing() ? last_usable : last_image) -
                               fromSeconds(2.0)
                         : std::min(startup->oldestTime(), last_usable) - fromSeconds(2.0));
    }
  }
  out.segment = segment;
  results.push_back(out);
}

TrackedFrame VisualInertialEstimator::Impl::track(TimeNs t, const cv::Mat& gray,
                                                  FrameEstimate* out) {
  Mat3 R_C0_C1 = Mat3::Identity();
  if (last_usable > 0 && t > last_usable) {
    const Vec3 bg = running ? window->newest().bg : startup->gyroBias();
    const Preintegration p = imu.integrate(last_usable, t, config.imu, bg, Vec3::Zero());
    R_C0_C1 = (T_B_C.q.conjugate() * p.dq() * T_B_C.q).toRotationMatrix();
  }
  TrackedFrame frame = tracker->process(t, gray, R_C0_C1);
  if (!frame.usable) ++counters.images_unusable;
  if (!frame.usable && !in_dark) {
    warn("images from " + std::to_string(t) + " ns on cannot be used: " + frame.reason);
  }
  in_dark = !frame.usable;
  out->tracks = static_cast<int>(frame.features.size());
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
  out->valid = true;
  out->state = window->newest();
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
  out->state = window->newest();
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
  for (const NavState& s : window->states()) old_keyframes.push_back(s);
  window->clear();
  startup->reset();
  tracker->reset();
  rest.reset();
  running = false;
  last_usable = 0;  // nothing left to be matched against
}

bool VisualInertialEstimator::Impl::missesImu(TimeNs t) const {
  if (t > hole_start && t < hole_end) return true;
  return t > imu.lastTime() + fromSeconds(0.1);
}

void VisualInertialEstimator::Impl::collectRetired() {
  for (const NavState& s : window->takeRetiredKeyframes()) old_keyframes.push_back(s);
  for (const WindowLandmark& l : window->takeRetiredLandmarks()) old_landmarks.push_back(l);
}

VisualInertialEstimator::VisualInertialEstimator(const EstimatorConfig& config, LogSink log)
    : impl_(std::make_unique<Impl>(config, std::move(log))) {}
VisualInertialEstimator::~VisualInertialEstimator() = default;

void VisualInertialEstimator::setCamera(const CameraCalibration& calibration, const Pose& T_B_C) {
  impl_->setCamera(calibration, T_B_C);
}
bool VisualInertialEstimator::hasCamera() const { return impl_->tracker != nullptr; }

void VisualInertialEstimator::addImu(const ImuSample& sample) {
  const bool any = !impl_->imu.empty();
  const TimeNs last = any ? impl_->imu.lastTime() : 0;
  if (impl_->imu.add(sample)) {
    if (any && toSeconds(sample.t - last) > kImuHoleS) {
      ++impl_->counters.imu_gaps;
      impl_->hole_start = last;
      impl_->hole_end = sample.t;
    }
    impl_->stepped_back = 0;
    impl_->processWaiting(false);
    return;
  }
  if (impl_->imu.empty() || sample.t > impl_->imu.lastTime()) return;
  if (++impl_->stepped_back < kClockStepReadings) return;
  ++impl_->counters.clock_steps;
  impl_->stepped_back = 0;
  impl_->counters.images_without_imu += static_cast<long>(impl_->waiting.size());
  for (const auto& [t, image] : impl_->waiting) {
    FrameEstimate lost;
    lost.t = t;
    lost.segment = impl_->segment;
    lost.health = "the clock of the IMU was set back";
    impl_->results.push_back(lost);
  }
  impl_->waiting.clear();
  if (impl_->running) impl_->origin = impl_->window->newest().T_W_B;
  if (impl_->tracker) impl_->restart("the clock of the IMU was set back");
  impl_->imu.clear();
  impl_->any_image = false;
  impl_->last_image = impl_->last_usable = 0;
  impl_->imu.add(sample);
}

void VisualInertialEstimator::addImage(TimeNs t, const cv::Mat& gray) {
  if (!impl_->tracker) {
    throw std::logic_error("VisualInertialEstimator: setCamera must come before the first image");
  }
  ++impl_->counters.images;
  const TimeNs t_imu = t + fromSeconds(impl_->config.camera_time_offset_s);
  const bool after_waiting = impl_->waiting.empty() || t > impl_->waiting.back().first;
  if (!after_waiting || (impl_->any_image && t_imu <= impl_->last_image)) {
    ++impl_->counters.images_out_of_order;
    return;
  }
  if (impl_->waiting.empty() && impl_->imu.covers(t_imu)) {
    impl_->process(t, gray);
    return;
  }
  impl_->waiting.emplace_back(t, gray.clone());
  impl_->processWaiting(false);
}

void VisualInertialEstimator::finish() { impl_->processWaiting(true); }

std::vector<FrameEstimate> VisualInertialEstimator::take() {
  return std::exchange(impl_->results, {});
}

std::vector<NavState> VisualInertialEstimator::keyframes() const {
  std::vector<NavState> out = impl_->old_keyframes;
  if (impl_->window) {
    for (const NavState& s : impl_->window->states()) out.push_back(s);
  }
  return out;
}

std::vector<WindowLandmark> VisualInertialEstimator::landmarks() const {
  std::vector<WindowLandmark> out = impl_->old_landmarks;
  if (impl_->window) {
    for (const WindowLandmark& l : impl_->window->landmarks()) out.push_back(l);
  }
  return out;
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
