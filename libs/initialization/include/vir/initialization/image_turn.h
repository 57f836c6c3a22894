#pragma once
/// How a camera turned between two images, from tracks alone, and at which offset of the clocks,
/// and with which rotation of the camera in the body, the gyro says the same.
#include <optional>
#include <string>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/imu/imu_buffer.h"
#include "vir/initialization/inertial_alignment.h"

namespace vir::initialization {

/// Mean angular rate of the camera between two images.
struct ImageTurn {
  TimeNs t0 = 0, t1 = 0;
  Vec3 rate_C = Vec3::Zero();       ///< [rad/s], camera frame
  Mat3 information = Mat3::Zero();  ///< of `rate_C`, for sights that are right to 1 px
};

/// Rotation and direction of translation that fit the sights of two images best (epipolar
/// geometry, robust, fixed iterations; no gyro). Sights ordered by id. Nothing if fewer than 12
/// tracks are shared or they contradict each other.
std::optional<ImageTurn> turnBetween(TimeNs t0, const std::vector<AlignmentSight>& first, TimeNs t1,
                                     const std::vector<AlignmentSight>& second, double focal_px);

struct TurnSearch {
  double max_offset_s = 0.2;  ///< searched to both sides
  double step_s = 0.004;
};

/// What images and gyro say of each other.
struct TurnCorrelation {
  bool ok = false;       ///< enough motion, and one answer only
  std::string reason;    ///< why not
  double offset_s = 0;   ///< to be added to the turns' times to be on the gyro's clock
  double sigma_s = 0;    ///< of that
  double explained = 0;  ///< share of the gyro's variation that the images explain there, 0..1
  /// How much worse no offset fits: difference of squared whitened residuals.
  double against_none = 0;
  Vec3 gyro_bias = Vec3::Zero();  ///< [rad/s]
  int turns = 0;
};

/// Searches the offset with the camera's rotation as given. Turns in order of time; they may
/// overlap. Turns that the readings do not cover at an offset are left out there.
TurnCorrelation correlateTurns(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& imu,
                               const Quat& q_B_C, const TurnSearch& search = {});

struct CameraRotation {
  bool ok = false;
  Quat q_B_C = Quat::Identity();
  double offset_s = 0;
  double sigma_rad = 0;  ///< of the worst axis
  double explained = 0;
};

/// Searches rotation and offset together, from nothing known of either. Needs turns about at least
/// two axes.
CameraRotation findCameraRotation(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& imu,
                                  const TurnSearch& search = {});

}  // namespace vir::initialization
