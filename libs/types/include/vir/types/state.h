#pragma once
/// Where the robot is, how it moves, and how sure that is.
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"
#include "vir/types/calibration.h"

namespace vir {
inline namespace types {

/// A pose at a time: of a keyframe, of a trajectory, of an odometry (its frame O is then the W).
struct StampedPose {
  TimeNs t = 0;
  Pose T_W_B;
};

/// Stamps strictly increasing.
using Trajectory = std::vector<StampedPose>;

/// The state of the body at one time on the clock of the IMU.
struct State {
  TimeNs t = 0;
  Pose T_W_B;
  Vec3 v = Vec3::Zero();   ///< v_W_B [m/s]
  Vec3 bg = Vec3::Zero();  ///< bias of the gyro [rad/s]
  Vec3 ba = Vec3::Zero();  ///< bias of the accelerometer [m/s^2]
};

/// How far a state can be relied on; `StateEstimate::reason` says why.
enum class Health {
  starting,  ///< no state yet
  ok,
  standing,  ///< at rest, and known to be
  doubtful,  ///< there is a state, but something speaks against it
  lost,      ///< there was a state, and there is none now
};
const char* name(Health health);

/// Milliseconds of CPU time in the stages of one image (reporting only).
struct StageTimes {
  double pyramid = 0, flow = 0, detect = 0, initialise = 0, optimise = 0, marginalise = 0,
         total = 0;
};

/// The state as estimated when one image (or odometry pose) was processed: causal.
struct StateEstimate {
  TimeNs t_image = 0;  ///< stamp of the image on its own clock; `state.t` is on the IMU's
  bool valid = false;  ///< false: `state` holds its time only; `health` and `reason` say why
  State state;
  /// Of (position in W [m], rotation on the right [rad]); zero if unknown.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int segment = 0;  ///< counts up when the estimator had to start anew
  bool keyframe = false;
  int cameras = 1;  ///< of a rig: whose images it is of
  int tracks = 0;
  int landmarks = 0;
  double reprojection_rms = 0;  ///< in sigma_px
  Calibration calibration;      ///< as used; without intrinsics: nothing was estimated
  double inertial_rms = 0;      ///< how the readings fit the images, in sigmas of the IMU
  double odometry_scale = 1;    ///< metres of an odometry per true metre
  Health health = Health::starting;
  std::string reason;  ///< short: "too little parallax", "no landmarks, IMU only"; may be empty
  StageTimes ms;
};

/// "ok", or the word and the reason: "starting: too little parallax".
std::string healthText(const StateEstimate& estimate);

/// States before now that have changed: by a closed loop or an anchor that was found. Ordered by
/// time; each replaces the pose of that time.
struct Revision {
  TimeNs t = 0;  ///< of the state that brought it about
  std::vector<StampedPose> keyframes;
};

/// A map point.
struct Landmark {
  std::uint64_t id = 0;
  Vec3 p_W = Vec3::Zero();  ///< [m]
};

}  // namespace types
}  // namespace vir
