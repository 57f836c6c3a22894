#pragma once
/// Closed-form start of a moving camera and IMU: gyro bias from the images' rotation, then
/// velocity, gravity and metric positions from one linear least-squares problem over all tracks,
/// with the length of gravity known.
#include <string>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/imu/preintegration.h"

namespace vir::initialization {

/// One track's sight for the alignment: which track, and its unit bearing in the camera.
struct AlignmentSight {
  std::uint64_t id = 0;
  Vec3 bearing = Vec3::UnitZ();
};

/// One image of the start-up window. Sights are ordered by id.
struct AlignmentFrame {
  TimeNs t = 0;
  std::vector<AlignmentSight> sights;
  imu::Preintegration link;  ///< from the previous frame; not used in the first
};

struct GyroBiasEstimate {
  bool ok = false;
  Vec3 bias = Vec3::Zero();  ///< [rad/s]
  double rms_px = 0;         ///< of the epipolar residuals after the solution
  int pairs = 0;             ///< frame pairs that took part
  std::string reason;
};

/// Gyro bias that makes the gyro's rotations agree with the epipolar geometry of all frame pairs
/// (each pair's direction of translation is free). Gauss-Newton with Huber weights, fixed
/// iterations. `focal_px` turns bearings into pixels. Needs >= 2 frames that share >= 10 tracks.
GyroBiasEstimate estimateGyroBias(const std::vector<AlignmentFrame>& frames, const Quat& q_B_C,
                                  double focal_px, const Vec3& start);

struct InertialAlignment {
  bool ok = false;
  std::string reason;        ///< why not
  std::vector<Vec3> p_B0;    ///< body positions in the first body frame [m]
  std::vector<Vec3> v_B0;    ///< velocities in the first body frame [m/s]
  std::vector<Quat> q_B0_B;  ///< rotations to the first body frame
  Vec3 g_B0 = Vec3::Zero();  ///< gravity in the first body frame, length as given [m/s^2]
  double residual_px = 0;    ///< rms of the linear problem's residual, in pixels at unit depth
};

/// Linear alignment; the links must be integrated with the gyro bias found before. Each track's
/// point is eliminated; what is left is a 6x6 problem in the first velocity and gravity, solved
/// with |g| = `gravity` exactly (Lagrange multiplier).
InertialAlignment alignInertial(const std::vector<AlignmentFrame>& frames, const Pose& T_B_C,
                                double gravity, double focal_px);

}  // namespace vir::initialization
