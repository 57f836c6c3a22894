#pragma once
/// What an autopilot is told, and what it asks, as MAVLink 2 frames
/// (https://mavlink.io/en/messages/common.html; frames as PX4's and ArduPilot's documents ask).
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vir/geometry/axes.h"
#include "vir/types/state.h"

namespace vir::live {

/// Who sends.
struct MavlinkSender {
  int system = 1;       ///< the vehicle's number
  int component = 197;  ///< MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY
};

/// A pose as an autopilot wants it: of its own reference point F, whose axes are forward, right,
/// down, in a local frame L whose z is down and whose heading is free (MAV_FRAME_LOCAL_FRD).
struct MavlinkPose {
  TimeNs t = 0;
  Pose T_L_F;
  Vec3 v_F = Vec3::Zero();     ///< velocity of F against L, in F [m/s]
  Vec3 rate_F = Vec3::Zero();  ///< [rad/s]
  /// Of (x, y, z [m] in L; roll, pitch, yaw [rad]).
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
  int resets = 0;   ///< how often L has jumped against the vehicle
  int quality = 0;  ///< 1 worst to 100 best, 0 unknown, -1 failed
};

/// Where the autopilot is on the robot.
struct AutopilotMounting {
  Mat3 R_F_B = axesRotation("x -y -z");
  Vec3 p_B_F = Vec3::Zero();  ///< [m]
};

/// `rate_B` [rad/s] without bias; `covariance` of (position in W, rotation on the right) as in
/// StateEstimate, all zero if unknown. Roll and yaw of a pitch within 0.06 deg of +-90 deg have the
/// variances of that angle.
MavlinkPose autopilotPose(const State& state, const Vec3& rate_B,
                          const Eigen::Matrix<double, 6, 6>& covariance,
                          const AutopilotMounting& mounting);

/// Roll, pitch, yaw [rad] of a rotation as MAVLink has them: R = Rz(yaw) Ry(pitch) Rx(roll).
Vec3 rollPitchYaw(const Quat& q);

/// Makes frames and counts them. One thread at a time.
class MavlinkEncoder {
 public:
  explicit MavlinkEncoder(const MavlinkSender& sender) : sender_(sender) {}
  std::string heartbeat();
  /// ODOMETRY (331).
  std::string odometry(const MavlinkPose& pose);
  /// VISION_POSITION_ESTIMATE (102).
  std::string visionPosition(const MavlinkPose& pose);
  /// The answer to a TIMESYNC (111) that asked at `ts1` [ns of its clock] and found us at `now`.
  std::string timesyncAnswer(TimeNs now, std::int64_t ts1);

 private:
  std::string frame(int message, std::uint8_t crc_extra, std::string payload);

  MavlinkSender sender_;
  std::uint8_t sequence_ = 0;
};

/// Finds questions for the time (TIMESYNC with tc1 = 0) among an autopilot's bytes; everything else
/// passes. Bounded memory whatever the bytes are.
class TimesyncListener {
 public:
  /// `ts1` of each question that these bytes complete.
  std::vector<std::int64_t> feed(const std::uint8_t* bytes, std::size_t size);

 private:
  std::string pending_;
};

}  // namespace vir::live
