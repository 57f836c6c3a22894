#pragma once
/// The camera's clock against the gyro's: how far apart they are, and whether they run alike.
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/check/turning.h"
#include "vir/imu/imu_buffer.h"
#include "vir/initialization/image_turn.h"

namespace vir::check {

/// Stamp of an image + offset + rate * (stamp - origin) = its time on the IMU's clock.
struct ClockFit {
  bool ok = false;
  double offset_s = 0, sigma_s = 0;  ///< at `origin` where there is a rate, else of all
  int turns = 0;
  Vec3 gyro_bias = Vec3::Zero();  ///< [rad/s]
  TimeNs origin = 0;              ///< the first image
  bool runs_apart = false;        ///< the rate is beyond doubt, and beyond what clocks differ by
  double rate = 0, rate_sigma = 0;
  /// Of the recording in which an offset was found; 0: the rate is by all turns together.
  int pieces = 0;
  double first_s = 0, last_s = 0;  ///< when the first and the last are, since the origin
  double first_offset_s = 0, last_offset_s = 0;

  TimeNs onImuClock(TimeNs image) const;
};

/// `turns` in order of time.
ClockFit fitClock(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& readings,
                  const Mat3& R_B_C);

/// `rates`: the nominal rates [Hz] of both, as text.
std::vector<Finding> clockFindings(const ClockFit& fit, double given_s, double image_hz,
                                   double imu_hz, const std::string& camera_label,
                                   const std::string& imu_label);

}  // namespace vir::check
