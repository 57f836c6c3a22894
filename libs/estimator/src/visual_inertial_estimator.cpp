#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "back_end.h"
#include "front_end.h"
#include "hand_over.h"
#include "vir/core/time_bounds.h"

namespace vir::estimator {
namespace {

/// The IMU going on for so long after the last image is no way of ending a recording [s].
constexpr double kSilentEnd_s = 2;

/// What a tracker of somebody else may say: no numbers, or none that an image can show.
bool isNoSight(const vision::FeatureObservation& f) {
  constexpr double kLargest = 1e6;  // [px], [1/s]
  const auto within = [](const auto& values) {
    return values.allFinite() && values.cwiseAbs().maxCoeff() < kLargest;
  };
  return !within(f.px) || !within(f.bearing) || !within(f.dpx_dbearing) ||
         !within(f.bearing_rate) || std::abs(f.bearing.norm() - 1) > 1e-3;
}

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
  describe(v, o.long_window);
  describe(v, o.ranges);
  describe(v, o.rest);
  describe(v, o.failure);
  v.section("Camera", "What the recording does not say about the camera");
  v.value("time_offset_s", o.camera_time_offset_s, {-10.0, 10.0},
          "image stamp + offset = IMU clock");
  v.section("Imu", "");
  v.value("gyro_gain", o.gyro_gain, 3, "the gyro's gain is off by this much per axis (relative)");
  v.value("gyro_axes_rad", o.gyro_axes_rad, 3,
          "turn of the gyro's axes against the accelerometer's");
  v.value("acc_gain", o.acc_gain, 3,
          "the accelerometer's gain is off by this much per axis (relative)");
}

struct VisualInertialEstimator::Impl {
  Impl(const EstimatorConfig& c, LogSink log)
      : config(c),
        back_end(config, std::move(log)),
        hand_over([this](Packet packet) { return back_end.process(std::move(packet)); },
                  config.pipelined ? 1 : 0),
        front_end(
            config, [this](long* covered) { return hand_over.ask(covered); },
            [this](Packet packet) { hand_over.give(std::move(packet)); }) {}

  /// Times are added and compared from here on: what no clock shows does not get in.
  bool hasStamp(TimeNs t) {
    if (isStamp(t)) return true;
    ++bad_stamps;
    return false;
  }

  const EstimatorConfig config;
  BackEnd back_end;
  HandOver hand_over;  // after `back_end`: its thread ends before that
  FrontEnd front_end;
  long bad_stamps = 0, bad_features = 0;
};

VisualInertialEstimator::VisualInertialEstimator(const EstimatorConfig& config, LogSink log) {
  config.validate();
  impl_ = std::make_unique<Impl>(config, std::move(log));
}
VisualInertialEstimator::~VisualInertialEstimator() = default;

void VisualInertialEstimator::workBehind(std::function<void()> on_estimates) {
  impl_->hand_over.startThread(std::move(on_estimates));
}

void VisualInertialEstimator::setCamera(const CameraCalibration& calibration, const Pose& T_B_C) {
  impl_->hand_over.drain();
  impl_->front_end.setCamera(calibration, T_B_C);
  impl_->back_end.setCamera(calibration, T_B_C);
}
int VisualInertialEstimator::addCamera(const CameraMount& mount) {
  if (!hasCamera()) {
    throw std::logic_error("VisualInertialEstimator: setCamera must come before addCamera");
  }
  impl_->hand_over.drain();
  const int number = impl_->front_end.addCamera(mount);
  impl_->back_end.addCamera(mount);
  return number;
}
bool VisualInertialEstimator::hasCamera() const { return impl_->front_end.hasCamera(); }

void VisualInertialEstimator::addImu(const ImuSample& sample) {
  if (impl_->hasStamp(sample.t)) impl_->front_end.addImu(sample);
}

void VisualInertialEstimator::addImage(TimeNs t, const cv::Mat& gray, int camera) {
  if (!hasCamera()) {
    throw std::logic_error("VisualInertialEstimator: setCamera must come before the first image");
  }
  if (camera < 0 || camera >= impl_->front_end.cameras()) {
    throw std::invalid_argument("VisualInertialEstimator: an image of camera " +
                                std::to_string(camera) + ", which was not added");
  }
  if (!impl_->hasStamp(t)) return;
  WaitingImage image;
  image.t = t;
  image.camera = camera;
  image.gray = gray;
  impl_->front_end.addImage(std::move(image));
}

void VisualInertialEstimator::addTracks(const vision::TrackedFrame& tracks) {
  if (!hasCamera()) {
    throw std::logic_error("VisualInertialEstimator: setCamera must come before the first tracks");
  }
  if (!impl_->hasStamp(tracks.t)) return;
  WaitingImage image;
  image.t = tracks.t;
  image.tracks = std::make_shared<vision::TrackedFrame>(tracks);
  std::vector<vision::FeatureObservation>& features = image.tracks->features;
  features.erase(std::remove_if(features.begin(), features.end(), isNoSight), features.end());
  impl_->bad_features += static_cast<long>(tracks.features.size() - features.size());
  impl_->front_end.addImage(std::move(image));
}

void VisualInertialEstimator::addRange(const Range& range) {
  if (impl_->config.ranges.use && impl_->hasStamp(range.t)) impl_->front_end.addRange(range);
}

void VisualInertialEstimator::addAnchorRange(const AnchorRange& range) {
  if (impl_->config.ranges.use) impl_->front_end.addAnchorRange(range);
}

void VisualInertialEstimator::anchorDeployed(std::uint64_t id, const Vec3& p_B, double sigma_m) {
  impl_->front_end.addDeployedAnchor({id, p_B, sigma_m});
}

void VisualInertialEstimator::finish() {
  try {
    impl_->front_end.finish();
  } catch (...) {
    impl_->hand_over.wait();
    throw;
  }
  impl_->hand_over.drain();
  const double silent_s = impl_->front_end.readingsAfterImagesS();
  if (silent_s < kSilentEnd_s) return;
  char text[120];
  std::snprintf(text, sizeof text,
                "no image in the last %.1f s, in which the IMU went on: no poses are given there",
                silent_s);
  impl_->back_end.warnings.push_back(text);
}

std::vector<StateEstimate> VisualInertialEstimator::take() {
  return std::exchange(impl_->back_end.results, {});
}
std::vector<FollowedPose> VisualInertialEstimator::followed() const {
  return impl_->back_end.followedInWindows();
}
std::vector<FollowedPose> VisualInertialEstimator::takeSettled() {
  return impl_->back_end.old_keyframes.takeSettled();
}
std::vector<RangeRecord> VisualInertialEstimator::takeRanges() {
  return impl_->back_end.ranges.take();
}
std::vector<KeyframeSights> VisualInertialEstimator::takeSights() {
  return std::exchange(impl_->back_end.sights, {});
}
std::vector<Anchor> VisualInertialEstimator::anchors() const {
  return impl_->back_end.ranges.anchors();
}
std::optional<SurveyFit> VisualInertialEstimator::survey() const {
  return impl_->back_end.ranges.survey();
}
std::vector<std::pair<std::string, long>> VisualInertialEstimator::rangeCounters() const {
  return impl_->back_end.ranges.counters();
}
std::vector<State> VisualInertialEstimator::keyframes() const {
  return impl_->back_end.keyframes();
}
std::vector<Landmark> VisualInertialEstimator::landmarks() const {
  return impl_->back_end.landmarks();
}
const std::vector<Eigen::Vector2f>& VisualInertialEstimator::trackedPixels() const {
  return impl_->back_end.pixels;
}

EstimatorCounters VisualInertialEstimator::counters() const {
  EstimatorCounters out = impl_->front_end.counters();
  out.imu_gaps += impl_->back_end.imu_gaps;
  out.bad_stamps = impl_->bad_stamps;
  out.bad_features = impl_->bad_features;
  out.images_misstamped = impl_->back_end.images_misstamped;
  out.imu_contradicted = impl_->back_end.imu_contradicted;
  return out;
}
const imu::ImuBufferCounters& VisualInertialEstimator::imuCounters() const {
  return impl_->front_end.imuCounters();
}
Calibration VisualInertialEstimator::calibration() const {
  const BackEnd& back = impl_->back_end;
  if (!back.window) {
    Calibration out;
    out.T_B_C = back.T_B_C;
    out.time_offset_s = back.time_offset_s;
    out.further = back.given.further;
    return out;
  }
  return back.window->calibration();
}
Calibration VisualInertialEstimator::givenCalibration() const { return impl_->back_end.given; }
std::optional<CalibrationSigma> VisualInertialEstimator::calibrationSigma() const {
  const BackEnd& back = impl_->back_end;
  if (!back.window || !impl_->config.window.calibrate) return std::nullopt;
  return back.window->calibrationSigma();
}

std::vector<CalibrationSigma> VisualInertialEstimator::furtherSigma() const {
  const BackEnd& back = impl_->back_end;
  if (!back.window || !impl_->config.window.calibrate) return {};
  return back.window->furtherSigma();
}

std::vector<window::RigDistance> VisualInertialEstimator::rigDistances() const {
  const BackEnd& back = impl_->back_end;
  if (!back.window || !impl_->config.window.calibrate) return {};
  return back.window->rigDistances();
}

std::optional<CalibrationCovariance> VisualInertialEstimator::calibrationCovariance() const {
  const BackEnd& back = impl_->back_end;
  if (!back.window || !impl_->config.window.calibrate) return std::nullopt;
  return back.window->calibrationCovariance();
}

std::vector<std::string> VisualInertialEstimator::doubts() const {
  return impl_->back_end.doubts.all();
}

int VisualInertialEstimator::resets() const { return impl_->back_end.segment; }
const std::vector<std::string>& VisualInertialEstimator::warnings() const {
  return impl_->back_end.warnings;
}

std::string VisualInertialEstimator::longestWaitReason() const {
  std::string best;
  double longest = 0;
  for (const auto& [reason, seconds] : impl_->back_end.wait_reasons) {
    if (!reason.empty() && seconds > longest) {
      longest = seconds;
      best = reason;
    }
  }
  return best;
}

}  // namespace vir::estimator
