#pragma once
/// Internal: what comes in, put into an order the back end can work on, and tracked.
#include <deque>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "elapsed.h"
#include "packet.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/imu/spike_filter.h"

namespace vir::estimator {

/// An image, or the tracks found in one, that waits for the readings up to its time.
struct WaitingImage {
  TimeNs t = 0;    ///< its own clock
  int camera = 0;  ///< of the rig
  cv::Mat gray;
  std::unique_ptr<vision::TrackedFrame> tracks;  ///< instead of an image
};

class FrontEnd {
 public:
  /// `ask` gives the feedback that must be known before the next image is tracked, with the number
  /// of packets it covers; `send` takes a packet.
  FrontEnd(const EstimatorConfig& config, std::function<Feedback(long* covered)> ask,
           std::function<void(Packet)> send);

  void setCamera(const CameraCalibration& calibration, const Pose& T_B_C);
  /// See VisualInertialEstimator::addCamera().
  int addCamera(const CameraMount& mount);
  bool hasCamera() const { return tracker_ != nullptr; }
  int cameras() const { return 1 + static_cast<int>(further_.size()); }
  void addImu(const ImuSample& sample);
  /// Pixels are copied if the image has to wait.
  void addImage(WaitingImage image);
  void addRange(const Range& range) { next_.ranges.push_back(range); }
  void addAnchorRange(const AnchorRange& range) { next_.anchor_ranges.push_back(range); }
  void addDeployedAnchor(const DeployedAnchor& anchor) { next_.deployed_anchors.push_back(anchor); }
  void finish();

  const EstimatorCounters& counters() const { return counters_; }
  const imu::ImuBufferCounters& imuCounters() const { return imu_.counters(); }

 private:
  void processWaiting(bool force);
  void process(const WaitingImage& image);
  void track(TimeNs t, const WaitingImage& image);
  /// Does t lie in a hole of the readings, or well behind the last of them?
  bool missesImu(TimeNs t) const;
  /// Rotation of the camera between two times, from the gyro: R_C(t0)_C(t).
  Mat3 rotationSince(TimeNs t0, TimeNs t);
  void follow(Feedback feedback);
  void retime(double time_offset_s);
  /// One that is no spike.
  void takeImu(const ImuSample& sample);
  void clockSetBack(const ImuSample& sample);
  void sendOn(Packet::Kind kind, TimeNs stamp);
  TimeNs onImuClock(TimeNs stamp) const;

  const EstimatorConfig& config_;
  std::function<Feedback(long*)> ask_;
  std::function<void(Packet)> send_;
  std::unique_ptr<vision::FeatureTracker> tracker_;
  Pose T_B_C_;
  std::vector<CameraMount> further_;
  imu::SpikeFilter spikes_;
  imu::ImuBuffer imu_;  // only for the rotation between images
  std::deque<WaitingImage> waiting_;
  Packet next_;
  std::optional<Vec3> turning_C_;  // see Feedback
  Vec3 gyro_bias_ = Vec3::Zero();
  EstimatorCounters counters_;
  double time_offset_s_;  // stamp of an image + this = its time on the IMU's clock
  int resets_ = 0;
  bool in_dark_ = false;  // warn once per stretch
  long stepped_back_ = 0;
  bool any_image_ = false;
  Elapsed elapsed_;
  TimeNs last_image_ = 0;   // on the IMU clock
  TimeNs last_usable_ = 0;  // 0: nothing to be matched against
};

}  // namespace vir::estimator
