#pragma once
/// The gyro against the turning of the images: unit, axes, the camera's rotation on the IMU, and
/// how far their clocks are apart.
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/check/force_sign.h"
#include "vir/check/turning.h"
#include "vir/types/calibration.h"
#include "vir/types/imu_sample.h"

namespace vir::imu {
class ImuBuffer;
}

namespace vir::check {

struct ClockFit;

/// The same piece of time, as seen by both.
struct TurnPair {
  TimeNs t0 = 0, t1 = 0;
  Vec3 image_C = Vec3::Zero();  ///< mean angular rate by the images, camera frame [rad/s]
  Vec3 gyro_B = Vec3::Zero();   ///< mean angular rate by the gyro, body frame [rad/s]
};

/// What turning says of camera and gyro, and what others may rest on.
struct TurningVerdict {
  std::vector<Finding> findings;
  /// The camera in the body, as given or as found; empty where turning cannot confirm any.
  std::optional<Mat3> R_B_C;
  ForceSign force;                ///< with that rotation
  Vec3 gyro_bias = Vec3::Zero();  ///< [rad/s]
  bool gyro_trusted = true;       ///< unit and axes of the gyro are right, as far as is known
};

class TurningCheck {
 public:
  TurningCheck(std::string imu_label, std::string camera_label)
      : imu_label_(std::move(imu_label)), camera_label_(std::move(camera_label)) {}
  void add(const ImuSample& sample);
  void add(const ImageTurn& turn);
  /// The camera through which the matches of the turns were seen.
  void setCamera(const CameraCalibration& camera) { camera_ = camera; }
  /// Pieces of time with the readings of the gyro in them: what a time offset is found from.
  const std::vector<TurnPair>& pairs() const { return pairs_; }
  /// `R_B_C`: the camera's rotation on the IMU as given. `time_offset_s`: stamp of an image + this
  /// = IMU's clock, as given.
  TurningVerdict verdict(const Mat3& R_B_C, double time_offset_s) const;
  std::vector<Finding> findings(const Mat3& R_B_C, double time_offset_s) const {
    return verdict(R_B_C, time_offset_s).findings;
  }

 private:
  std::vector<TurnPair> aligned(const imu::ImuBuffer& readings, const ClockFit& clock) const;
  void judgeCamera(std::vector<TurnPair> turning, const imu::ImuBuffer& readings,
                   const ClockFit& clock, const Mat3& R_B_C_given, TurningVerdict* out) const;
  void pairUp();
  void keepBeside(const ImuSample& sample);

  std::string imu_label_, camera_label_;
  std::optional<CameraCalibration> camera_;
  std::deque<ImuSample> readings_;  ///< since the oldest turn that waits
  std::deque<ImageTurn> waiting_;
  std::vector<TurnPair> pairs_;
  std::vector<ImageTurn> turns_;   ///< all, bounded as pairs_ are
  std::vector<ImuSample> beside_;  ///< readings of that time, and some before it
};

}  // namespace vir::check
