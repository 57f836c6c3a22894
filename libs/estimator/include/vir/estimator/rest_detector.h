#pragma once
/// Is the platform standing still? Decided by the image (tracks stay where they were in a reference
/// image) and confirmed by the IMU (no vibration): the IMU alone cannot tell rest from steady
/// motion.
#include <vector>

#include "vir/imu/imu_buffer.h"
#include "vir/vision/feature_tracker.h"

namespace vir::estimator {

struct RestOptions {
  double min_time_s = 0.4;
  double max_flow_px = 0.4;
  double max_gyro_std_radps = 0.03;
  double max_acc_std_mps2 = 0.4;
  int min_tracks = 15;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Rest].
void describe(OptionVisitor& v, RestOptions& o);

class RestDetector {
 public:
  explicit RestDetector(const RestOptions& options) : options_(options) {}
  void reset() {
    reference_.clear();
    standing_ = false;
  }
  /// Updates with an image; true if standing still since `since()`.
  bool update(const vision::TrackedFrame& frame, const imu::ImuBuffer& imu);
  bool standing() const { return standing_; }
  TimeNs since() const { return reference_t_; }

 private:
  void setReference(const vision::TrackedFrame& frame);
  RestOptions options_;
  std::vector<vision::FeatureObservation> reference_;
  TimeNs reference_t_ = 0;
  bool standing_ = false;
};

}  // namespace vir::estimator
