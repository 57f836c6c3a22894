#pragma once
/// Internal: the state of the estimator, shared by its translation units (intake, main loop).
#include <time.h>

#include <deque>
#include <map>
#include <opencv2/core/mat.hpp>

#include "vir/estimator/visual_inertial_estimator.h"

namespace vir {

/// Without an image for longer, the tracks are not expected to survive.
constexpr double kImageGapS = 0.5;

/// Position [m] and yaw [rad] of the first frame are the world's by definition.
constexpr double kStartSigma = 1e-3;

/// CPU time of this thread [ms] (reporting only).
inline double cpuMs() {
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

/// An image, or the tracks found in one, that waits for the readings up to its time.
struct WaitingImage {
  TimeNs t = 0;  ///< its own clock
  cv::Mat gray;
  std::unique_ptr<TrackedFrame> tracks;  ///< instead of an image
};

struct VisualInertialEstimator::Impl {
  Impl(const EstimatorConfig& c, LogSink l)
      : config(c),
        log_sink(std::move(l)),
        rest(c.rest),
        long_window(c.long_window),
        ranges(c.ranges, &long_window, log_sink) {}

  void setCamera(const CameraCalibration& calibration, const Pose& extrinsics);
  void offer(WaitingImage image);
  void process(const WaitingImage& image);
  void processWaiting(bool force);
  /// Rotation of the camera between two times, from the gyro: R_C(t0)_C(t).
  Mat3 rotationSince(TimeNs t0, TimeNs t);
  TrackedFrame track(TimeNs t, const WaitingImage& image, FrameEstimate* out);
  void clockSetBack(const ImuSample& sample);
  void dropOldReadings();
  void tryStart(const TrackedFrame& frame, FrameEstimate* out);
  void update(const TrackedFrame& frame, FrameEstimate* out);
  std::string failure(const TrackedFrame& frame, const SolveSummary& solve, TimeNs t);
  void restart(const std::string& why);
  /// Does t lie in a hole of the readings, or well behind the last of them?
  bool missesImu(TimeNs t) const;
  void collectRetired();

  // Where the windows and the ranges meet (double_window.cpp).
  /// Ranges up to the newest frame's time are judged and hung on it. States in O.
  void attachRanges(const NavState& previous, const NavState& newest);
  /// Ranges held by the keyframes of both windows, `motion` being the antenna in W.
  std::vector<HeldRange> heldRanges(std::uint64_t key) const;
  void updateAnchors(TimeNs t);
  void startLongWindow();
  NavState inWorld(const NavState& s) const;
  Eigen::Matrix<double, 6, 6> covarianceInWorld() const;
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
  LongWindow long_window;
  RangeLayer ranges;
  std::deque<WaitingImage> waiting;
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
  std::vector<Eigen::Vector2f> pixels;  // of the features of the last image
  bool in_gap = false, in_dark = false;  // warn once per stretch
  long stepped_back = 0;
  bool any_image = false;
  TimeNs last_image = 0;  // on the IMU clock
  TimeNs last_usable = 0;
  TimeNs last_seen = 0;  // last time landmarks held the pose
};

}  // namespace vir
