#pragma once
/// Internal: what comes in, put into an order the back end can work on, and tracked.
#include <deque>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "elapsed.h"
#include "image_sets.h"
#include "packet.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/imu/spike_filter.h"
#include "vir/vision/rig_tracker.h"

namespace vir::estimator {

class FrontEnd {
 public:
  /// `ask` gives the feedback that must be known before the next image is tracked, with the number
  /// of packets it covers; `send` takes a packet.
  FrontEnd(const EstimatorConfig& config, std::function<Feedback(long* covered)> ask,
           std::function<void(Packet)> send);

  void setCamera(const CameraCalibration& calibration, const Pose& T_B_C);
  /// See VisualInertialEstimator::addCamera().
  int addCamera(const CameraMount& mount);
  bool hasCamera() const { return !cameras_.empty(); }
  int cameras() const { return static_cast<int>(cameras_.size()); }
  void addImu(const ImuSample& sample);
  /// Pixels are copied if the image has to wait.
  void addImage(WaitingImage image);
  void addRange(const Range& range) { next_.ranges.push_back(range); }
  void addAnchorRange(const AnchorRange& range) { next_.anchor_ranges.push_back(range); }
  void addDeployedAnchor(const DeployedAnchor& anchor) { next_.deployed_anchors.push_back(anchor); }
  void finish();

  /// Time from the last image to the last reading; 0 if there was none of them [s].
  double readingsAfterImagesS() const;
  const EstimatorCounters& counters() const { return counters_; }
  const imu::ImuBufferCounters& imuCounters() const { return imu_.counters(); }

 private:
  void processWaiting(bool force);
  void process(const ImageSet& set);
  void track(TimeNs t, const ImageSet& set);
  /// Tracks of somebody else, or of all cameras together.
  vision::TrackedFrame trackAll(TimeNs t, const ImageSet& set);
  void addOfRig(WaitingImage image);
  /// Sets of a rig that are complete go on to those that wait for readings.
  void takeSets(bool all);
  void noteOutcomes(TimeNs t, const std::vector<vision::RigOutcome>& outcomes);
  void noteMatches(const vision::TrackedFrame& frame,
                   const std::vector<vision::RigOutcome>& outcomes);
  vision::RigTracker& tracker();
  /// Does t lie in a hole of the readings, or well behind the last of them?
  bool missesImu(TimeNs t) const;
  /// Rotation of the camera between two times, from the gyro: R_C(t0)_C(t).
  Mat3 rotationSince(TimeNs t0, TimeNs t, const Quat& q_B_C);
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
  /// One of the rig.
  struct Camera {
    std::shared_ptr<const camera::CameraModel> model;
    Pose T_B_C;
    TimeNs last_usable = 0;  ///< on the IMU clock; 0: nothing to be matched against
    bool in_dark = false;    ///< warn once per stretch
  };
  std::unique_ptr<vision::RigTracker> tracker_;  ///< from the first image on
  std::vector<Camera> cameras_;
  ImageSets sets_;  ///< of a rig
  imu::SpikeFilter spikes_;
  imu::ImuBuffer imu_;  // only for the rotation between images
  std::deque<ImageSet> waiting_;
  Packet next_;
  std::optional<Vec3> turning_C_;  // see Feedback
  Vec3 gyro_bias_ = Vec3::Zero();
  EstimatorCounters counters_;
  double time_offset_s_;  // stamp of an image + this = its time on the IMU's clock
  int resets_ = 0;
  long stepped_back_ = 0;
  bool any_image_ = false;
  Elapsed elapsed_;
  TimeNs last_image_ = 0;  // on the IMU clock
};

}  // namespace vir::estimator
