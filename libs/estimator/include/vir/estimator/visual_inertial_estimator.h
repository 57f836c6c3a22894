#pragma once
/// Camera, IMU and ranges to a state per image: the front end tracks (front_end.cpp), the back end
/// propagates, optimises and slides (back_end.cpp).
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/log.h"
#include "vir/estimator/range_layer.h"
#include "vir/estimator/startup.h"
#include "vir/imu/imu_buffer.h"
#include "vir/types/followed_pose.h"
#include "vir/types/state.h"
#include "vir/vision/feature_tracker.h"
#include "vir/window/short_window.h"

namespace vir::estimator {

struct FailureOptions {
  double max_blind_s = 5.0;
  double max_speed_mps = 50.0;
  double max_bias_acc = 3.0;
  double max_bias_gyro = 1.0;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Failure].
void describe(OptionVisitor& v, FailureOptions& o);

struct EstimatorConfig {
  imu::ImuNoise imu;
  vision::TrackerOptions tracker;
  window::WindowOptions window;
  window::LongWindowOptions long_window;
  RangeOptions ranges;
  StartupOptions startup;
  RestOptions rest;
  FailureOptions failure;
  double camera_time_offset_s = 0;  ///< image stamp + offset = IMU clock
  // Of the IMU, to begin with: see vir::Calibration.
  std::vector<double> gyro_gain{0, 0, 0}, gyro_axes_rad{0, 0, 0}, acc_gain{0, 0, 0};
  /// The tracker hears of the state one image later, so that an image can be tracked while the one
  /// before it is worked on.
  bool pipelined = false;
  bool tell_sights = false;  ///< keep what takeSights() gives; not a setting

  /// Throws std::invalid_argument for a value that is not allowed, and for values that contradict
  /// each other.
  void validate() const;
};
/// All sections.
void describe(OptionVisitor& v, EstimatorConfig& o);

/// Images of a camera beside the first.
struct FurtherCameraCounters {
  long images = 0;           ///< came
  long taken = 0;            ///< used together with others of that time, or alone
  long without_partner = 0;  ///< of `taken`: the first camera had none of that time
  long unusable = 0;         ///< black, blank, another size
  long out_of_order = 0;     ///< left out
  long looked_for = 0;       ///< sights of the first camera in images of both, should they overlap
  long matched = 0;          ///< of these, seen by this one too
};

struct EstimatorCounters {
  long images = 0, images_unusable = 0, images_out_of_order = 0, images_without_imu = 0;
  long imu_gaps = 0, image_gaps = 0, clock_steps = 0;
  long imu_spikes = 0, imu_impossible = 0;  ///< readings left out: see imu::SpikeFilter
  long bad_stamps = 0;    ///< images, readings and ranges left out: no clock shows that (isStamp)
  long bad_features = 0;  ///< of addTracks(), left out: numbers that no image can show
  long images_misstamped = 0;  ///< left out: they show where the readings were at another time
  long imu_contradicted = 0;   ///< images whose readings were left out: they put the sights far off
  long images_alone = 0;       ///< of the first camera, without one of any other of the rig
  std::vector<FurtherCameraCounters> further;  ///< of camera 1, 2, ...
};

/// Landmarks as a keyframe saw them when it was the newest image.
struct KeyframeSights {
  TimeNs t_image = 0;  ///< as of `StateEstimate`
  struct Sight {
    Vec2 px = Vec2::Zero();       ///< of the image as recorded
    double inverse_distance = 0;  ///< along its ray [1/m]
    double sigma = 0;             ///< of it [1/m]
  };
  std::vector<Sight> of;
};

class VisualInertialEstimator {
 public:
  /// Throws what `config.validate()` throws.
  explicit VisualInertialEstimator(const EstimatorConfig& config, LogSink log = {});
  ~VisualInertialEstimator();

  /// From now on the back end works in a thread of its own and calls `on_estimates` from there
  /// after every image. In that call all that gives results may be called, the counters excepted,
  /// and everything after finish(); at other times only what takes input. What the thread throws
  /// comes out of the next call that takes input. The results are those without the thread. Needs
  /// EstimatorConfig::pipelined, before any input: else std::logic_error.
  void workBehind(std::function<void()> on_estimates);
  /// Must be called before the first image. `T_B_C`: camera in body (= IMU) frame.
  void setCamera(const CameraCalibration& calibration, const Pose& T_B_C);
  /// Another camera of the rig: after setCamera(), before the first image. Returns its number: 1,
  /// 2, ... Throws std::invalid_argument for a calibration that cannot be, and std::logic_error if
  /// it comes too early or too late.
  int addCamera(const CameraMount& mount);
  bool hasCamera() const;
  void addImu(const ImuSample& sample);
  /// Images in time order; copied if it has to wait for readings. Readings up to its time make it
  /// processed; else it waits. `t` is on the clock of that camera. Images of several cameras are
  /// worked on together where they were taken within half the time between images; each camera's
  /// come in order of time. Throws std::invalid_argument for a camera that was not added.
  void addImage(TimeNs t, const cv::Mat& gray, int camera = 0);
  /// Tracks found by someone else instead of an image: the same for all that follows. Sights of
  /// several cameras (their `camera`) are taken to be of that time.
  void addTracks(const vision::TrackedFrame& tracks);
  /// Ranges in any order; each is used with the first image at or after its time.
  void addRange(const Range& range);
  /// Two anchors have measured how far they are apart.
  void addAnchorRange(const AnchorRange& range);
  /// The robot has just put down an anchor at `p_B` in its body frame. Without a pose at that time
  /// this says nothing of where the anchor is: counted and warned of, and its ranges have to tell.
  void anchorDeployed(std::uint64_t id, const Vec3& p_B, double sigma_m);
  /// The input has ended: images that wait are worked on with the readings there are. Nothing is
  /// done in the background afterwards, also if it throws.
  void finish();
  std::vector<StateEstimate> take();
  std::vector<RangeRecord> takeRanges();
  /// Keyframes that left the long window since this was last asked: they do not change any more.
  std::vector<FollowedPose> takeSettled();
  /// Those that have not left it, the newest included.
  std::vector<FollowedPose> followed() const;
  /// Of the keyframes among the states, in their order; none without EstimatorConfig::tell_sights.
  std::vector<KeyframeSights> takeSights();
  std::vector<Anchor> anchors() const;
  /// How the survey of the anchors lies in W; empty without one.
  std::optional<SurveyFit> survey() const;
  std::vector<std::pair<std::string, long>> rangeCounters() const;

  /// Keyframes that left the long window, then those in it and in the short one; in W. Beyond some
  /// thousand those that left are evenly thinned out, so that memory does not grow for hours.
  std::vector<State> keyframes() const;
  /// Map points that left the window (evenly thinned out beyond 60000), and those in it.
  std::vector<Landmark> landmarks() const;
  /// Where features were seen in the last image [px].
  const std::vector<Eigen::Vector2f>& trackedPixels() const;
  EstimatorCounters counters() const;
  const imu::ImuBufferCounters& imuCounters() const;
  /// As last estimated, or as given.
  Calibration calibration() const;
  /// What it began with: setCamera() and the configuration.
  Calibration givenCalibration() const;
  /// How sure that is; nothing if it was not estimated.
  std::optional<CalibrationSigma> calibrationSigma() const;
  /// The same of the cameras beside the first (Calibration::further), once there was a state.
  std::vector<CalibrationSigma> furtherSigma() const;
  /// Of the distances of those from the first, once there was a state.
  std::vector<window::RigDistance> rigDistances() const;
  /// The same in full, once there was a state.
  std::optional<CalibrationCovariance> calibrationCovariance() const;
  int resets() const;
  const std::vector<std::string>& warnings() const;
  /// What speaks against the states that were given, a text per kind.
  std::vector<std::string> doubts() const;
  /// The reason that kept initialisation waiting longest.
  std::string longestWaitReason() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::estimator
