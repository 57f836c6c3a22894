#pragma once
/// Is the platform standing still? Decided by the image (tracks stay where they were in a reference
/// image) and confirmed by the IMU: the IMU alone cannot tell rest from steady motion, and an image
/// that moves with the platform (a lift, a vehicle) or comes again and again (a camera that hangs)
/// cannot either. Idling motors shake the readings but not their mean, and nothing comes to rest
/// from full speed without the accelerometer's knowing.
#include <utility>
#include <vector>

#include "vir/imu/imu_buffer.h"
#include "vir/vision/feature_tracker.h"

namespace vir::estimator {

struct RestOptions {
  double min_time_s = 0.4;
  double max_flow_px = 0.4;
  double max_drift_px = 0.12;
  double max_gyro_std_radps = 0.03;
  double max_acc_std_mps2 = 0.4;
  int min_tracks = 15;
  int min_tracks_shaken = 40;
  double max_mean_gyro_radps = 0.02;
  double max_mean_acc_mps2 = 0.15;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Rest].
void describe(OptionVisitor& v, RestOptions& o);

class RestDetector {
 public:
  explicit RestDetector(const RestOptions& options)
      : options_(options), needed_s_(options.min_time_s) {}
  void reset() {
    reference_.clear();
    needed_s_ = options_.min_time_s;
    standing_ = shaken_ = false;
  }
  /// Updates with an image; true if standing still since `since()`.
  bool update(const vision::TrackedFrame& frame, const imu::ImuBuffer& imu);
  bool standing() const { return standing_; }
  TimeNs since() const { return reference_t_; }
  /// Standing, but the IMU feels motors: standard deviations of its readings.
  bool shaken() const { return standing_ && shaken_; }
  double gyroStd() const { return gyro_std_; }  ///< [rad/s], norm over the axes
  double accStd() const { return acc_std_; }    ///< [m/s^2]
  /// What rest would look like by all that is known before the image.
  struct Expected {
    Vec3 gyro_bias = Vec3::Zero();  ///< [rad/s]
    double gravity_mps2 = 9.81;     ///< length of the accelerometer's reading
    bool state_known = false;       ///< there is a state with biases: motion can be told from them
    bool moving = false;            ///< its speed is more than it may be off by
    /// Landmarks hold the pose: it does well without being called a rest, and a creep would show.
    bool held = false;
  };
  void setExpected(const Expected& expected) { expected_ = expected; }

 private:
  void compare(const vision::TrackedFrame& frame);
  void setReference(const vision::TrackedFrame& frame);
  bool meanAtRest(const Vec3& gyro, const Vec3& acc, double span_s, double margin) const;
  RestOptions options_;
  std::vector<vision::FeatureObservation> reference_;
  std::vector<std::pair<Vec2, Vec2>> flow_;  // pixel now, how far it has come from the reference
  TimeNs reference_t_ = 0;
  double needed_s_ = 0;  // how long nothing must have moved by now
  bool standing_ = false, shaken_ = false;
  double gyro_std_ = 0, acc_std_ = 0;
  Expected expected_;
};

}  // namespace vir::estimator
