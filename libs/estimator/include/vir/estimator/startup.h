#pragma once
/// From the first images to a running window: standing still, or in motion.
#include <deque>
#include <string>

#include "vir/estimator/rest_detector.h"
#include "vir/imu/imu_buffer.h"
#include "vir/types/calibration.h"
#include "vir/vision/feature_tracker.h"
#include "vir/window/short_window.h"

namespace vir::estimator {

struct StartupOptions {
  double min_span_s = 1.0;
  double max_span_s = 2.0;
  double max_scale_sigma = 0.02;
  double patience_s = 1.6;
  double patient_scale_sigma = 0.05;
  double max_tilt_sigma_deg = 1.5;
  double min_parallax_px = 15.0;
  int min_shared_tracks = 25;
  double max_reprojection_rms = 1.5;
  int iterations = 12;
  double sigma_bias_gyro = 0.05;
  double sigma_bias_acc = 0.15;
  bool allow_standing = true;

  /// Throws std::invalid_argument for a value that is not allowed, and for values that contradict
  /// each other.
  void validate() const;
};
/// Section [Startup].
void describe(OptionVisitor& v, StartupOptions& o);

enum class StartupStatus { waiting, started_moving, started_standing };

class Startup {
 public:
  Startup(const StartupOptions& options, const imu::ImuNoise& noise, const Pose& T_B_C,
          double focal_px);

  void reset();
  /// Keeps an image without trying, for a start that may have to be made later.
  void remember(const vision::TrackedFrame& frame);
  /// The camera's time offset has changed by this much.
  void shift(TimeNs by);
  /// How far off the camera's time offset may be, for the window; 0: it is exact.
  void setTimeOffsetSigma(double sigma_s) { time_offset_sigma_s_ = sigma_s; }
  /// Several cameras: with these, and with matches between them that lie `epipolar_px` beside where
  /// they should (0: none), depth is known from the first images on.
  void setRig(const Calibration& calibration, double epipolar_px) {
    rig_ = !calibration.further.empty();
    epipolar_px_ = epipolar_px;
  }
  /// Offers a tracked image (IMU readings up to its time are in `imu`). On success the window is
  /// filled, its newest frame is this image. The first frame of the window gets the position and
  /// the yaw of `origin`.
  StartupStatus offer(const vision::TrackedFrame& frame, imu::ImuBuffer& imu,
                      const RestDetector& rest, const Pose& origin, window::ShortWindow* window);
  /// As offer() does with the images it has, if it tried with the last one, with the camera's time
  /// offset changed by `by_s`.
  StartupStatus offerAgain(double by_s, imu::ImuBuffer& imu, const Pose& origin,
                           window::ShortWindow* window);
  /// By how much the time offset was changed in the start that succeeded [s].
  double foundShift() const { return found_shift_s_; }
  /// Why it is still waiting: "too few tracks", "too little parallax", "rotation only", "no
  /// excitation", "scale uncertain", "inconsistent".
  const std::string& reason() const { return reason_; }
  /// Best guess of the gyro bias so far [rad/s]: the tracker needs it before there is a state.
  const Vec3& gyroBias() const { return gyro_bias_; }
  /// Time from which readings are still needed.
  TimeNs oldestTime() const { return frames_.empty() ? 0 : frames_.front().t; }
  /// Details of the last attempt, for the log.
  const std::string& detail() const { return detail_; }

 private:
  bool startStanding(const vision::TrackedFrame& frame, const imu::ImuBuffer& imu,
                     const RestDetector& rest, const Pose& origin, window::ShortWindow* window);
  /// Again with the time offset that the window finds, until that stays.
  bool startMoving(imu::ImuBuffer& imu, const Pose& origin, window::ShortWindow* window);
  bool startMovingOnce(imu::ImuBuffer& imu, const Pose& origin, window::ShortWindow* window);
  std::vector<const vision::TrackedFrame*> selectFrames() const;
  bool enoughMotion(const std::vector<const vision::TrackedFrame*>& frames, imu::ImuBuffer& imu);
  bool refine(window::ShortWindow* window);
  /// Do matches between cameras lie where the calibration has them?
  bool rigFits() const;
  /// With depth from several cameras: scale and pose by the images, the tilt by the readings.
  bool startWithRig(imu::ImuBuffer& imu, const Pose& origin, window::ShortWindow* window);

  StartupOptions options_;
  imu::ImuNoise noise_;
  Pose T_B_C_;
  double focal_px_;
  std::deque<vision::TrackedFrame> frames_;
  double time_offset_sigma_s_ = 0, found_shift_s_ = 0;
  Vec3 gyro_bias_ = Vec3::Zero();
  std::string reason_ = "waiting for images";
  std::string detail_;
  int since_attempt_ = 0;
  bool rig_ = false, by_rig_ = false;
  double epipolar_px_ = 0;
  bool tried_ = false;  // a moving start with the last image
  bool any_offer_ = false;
  TimeNs first_offer_ = 0;
};

}  // namespace vir::estimator
