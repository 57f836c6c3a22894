#include "vir/live/mavlink_messages.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vir/core/crc.h"
#include "vir/core/little_endian.h"

namespace vir::live {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Number, and the byte for the CRC that stands for the message's definition.
constexpr int kHeartbeat = 0, kVisionPosition = 102, kTimesync = 111, kOdometry = 331;
constexpr std::uint8_t kHeartbeatCrc = 50, kVisionPositionCrc = 158, kTimesyncCrc = 34,
                       kOdometryCrc = 91;
constexpr std::uint64_t kLocalFrd = 20, kBodyFrd = 12;  // MAV_FRAME
constexpr std::uint64_t kVisualInertial = 3;            // MAV_ESTIMATOR_TYPE_VIO
constexpr std::size_t kHead = 10, kCrcSize = 2, kTimesyncSize = 18;
constexpr double kLeastCosine = 1e-3;  // of the pitch

Mat3 flipped() { return Vec3(1, -1, -1).asDiagonal(); }  // W has z up, L has z down

/// Rates of roll, pitch and yaw from those about the axes of F.
Mat3 eulerRates(const Vec3& rpy) {
  const double sr = std::sin(rpy.x()), cr = std::cos(rpy.x());
  const double cp =
      std::copysign(std::max(std::abs(std::cos(rpy.y())), kLeastCosine), std::cos(rpy.y()));
  const double tp = std::sin(rpy.y()) / cp;
  Mat3 E;
  E << 1, sr * tp, cr * tp, 0, cr, -sr, 0, sr / cp, cr / cp;
  return E;
}

void putVector(std::string* out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) putFloat(out, v[i]);
}

/// The upper triangle by rows; an unknown one begins with NaN.
void putCovariance(std::string* out, const std::optional<Mat6>& covariance) {
  const Mat6 zero = Mat6::Zero();
  const Mat6& c = covariance ? *covariance : zero;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) {
      const bool unknown = !covariance && row == 0 && col == 0;
      putFloat(out, unknown ? std::numeric_limits<double>::quiet_NaN() : c(row, col));
    }
  }
}

std::uint64_t microseconds(TimeNs t) {
  return static_cast<std::uint64_t>(std::max<TimeNs>(t, 0) / 1000);
}

}  // namespace

Vec3 rollPitchYaw(const Quat& q) {
  const Mat3 R = q.toRotationMatrix();
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  if (std::hypot(R(2, 1), R(2, 2)) < kLeastCosine) {  // roll and yaw turn about one axis
    return {0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  }
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

MavlinkPose autopilotPose(const State& state, const Vec3& rate_B, const Mat6& covariance,
                          const AutopilotMounting& mounting) {
  const Mat3 R_L_W = flipped();
  const Mat3 R_W_B = state.T_W_B.q.toRotationMatrix();
  const Mat3& R_F_B = mounting.R_F_B;
  MavlinkPose out;
  out.t = state.t;
  out.T_L_F.q = Quat(Mat3(R_L_W * R_W_B * R_F_B.transpose())).normalized();
  out.T_L_F.p = R_L_W * (state.T_W_B.p + R_W_B * mounting.p_B_F);
  out.v_F = R_F_B * (R_W_B.transpose() * state.v + rate_B.cross(mounting.p_B_F));
  out.rate_F = R_F_B * rate_B;
  if (covariance.isZero(0) || !covariance.allFinite()) return out;
  Mat6 J = Mat6::Zero();
  J.topLeftCorner<3, 3>() = R_L_W;
  J.topRightCorner<3, 3>() = -R_L_W * R_W_B * hat(mounting.p_B_F);
  J.bottomRightCorner<3, 3>() = eulerRates(rollPitchYaw(out.T_L_F.q)) * R_F_B;
  out.covariance = J * covariance * J.transpose();
  return out;
}

std::string MavlinkEncoder::frame(int message, std::uint8_t crc_extra, std::string payload) {
  while (payload.size() > 1 && payload.back() == '\0') payload.pop_back();
  std::string out("\xFD", 1);
  put(&out, payload.size(), 1);
  put(&out, 0, 2);  // nothing that one must, or may, understand
  put(&out, sequence_++, 1);
  put(&out, static_cast<std::uint64_t>(sender_.system), 1);
  put(&out, static_cast<std::uint64_t>(sender_.component), 1);
  put(&out, static_cast<std::uint64_t>(message), 3);
  out += payload;
  const std::uint16_t crc = crc16Mavlink(bytesOf(out) + 1, out.size() - 1);
  put(&out, crc16Mavlink(&crc_extra, 1, crc), 2);
  return out;
}

std::string MavlinkEncoder::heartbeat() {
  std::string payload;
  put(&payload, 0, 4);
  put(&payload, 18, 1);  // MAV_TYPE_ONBOARD_CONTROLLER
  put(&payload, 8, 1);   // MAV_AUTOPILOT_INVALID: this is none
  put(&payload, 0, 1);
  put(&payload, 4, 1);  // MAV_STATE_ACTIVE
  put(&payload, 3, 1);  // version of MAVLink
  return frame(kHeartbeat, kHeartbeatCrc, std::move(payload));
}

std::string MavlinkEncoder::odometry(const MavlinkPose& pose) {
  std::string payload;
  put(&payload, microseconds(pose.t), 8);
  putVector(&payload, pose.T_L_F.p);
  const Quat& q = pose.T_L_F.q;
  for (const double v : {q.w(), q.x(), q.y(), q.z()}) putFloat(&payload, v);
  putVector(&payload, pose.v_F);
  putVector(&payload, pose.rate_F);
  putCovariance(&payload, pose.covariance);
  putCovariance(&payload, std::nullopt);  // of the velocity
  put(&payload, kLocalFrd, 1);
  put(&payload, kBodyFrd, 1);
  put(&payload, static_cast<std::uint64_t>(pose.resets), 1);
  put(&payload, kVisualInertial, 1);
  put(&payload, static_cast<std::uint64_t>(pose.quality), 1);
  return frame(kOdometry, kOdometryCrc, std::move(payload));
}

std::string MavlinkEncoder::visionPosition(const MavlinkPose& pose) {
  std::string payload;
  put(&payload, microseconds(pose.t), 8);
  putVector(&payload, pose.T_L_F.p);
  putVector(&payload, rollPitchYaw(pose.T_L_F.q));
  putCovariance(&payload, pose.covariance);
  put(&payload, static_cast<std::uint64_t>(pose.resets), 1);
  return frame(kVisionPosition, kVisionPositionCrc, std::move(payload));
}

std::string MavlinkEncoder::timesyncAnswer(TimeNs now, std::int64_t ts1) {
  std::string payload;
  put(&payload, static_cast<std::uint64_t>(now), 8);
  put(&payload, static_cast<std::uint64_t>(ts1), 8);
  return frame(kTimesync, kTimesyncCrc, std::move(payload));
}

std::vector<std::int64_t> TimesyncListener::feed(const std::uint8_t* bytes, std::size_t size) {
  std::vector<std::int64_t> asked;
  pending_.append(reinterpret_cast<const char*>(bytes), size);
  std::size_t at = 0;
  for (; at < pending_.size(); ++at) {
    const std::uint8_t* p = bytesOf(pending_) + at;
    const std::size_t left = pending_.size() - at;
    if (p[0] != 0xFD) continue;
    if (left >= 3 && (p[2] & ~0x01) != 0) continue;  // flags that nobody has defined
    if (left >= 2 && (p[1] == 0 || p[1] > kTimesyncSize)) continue;
    if (left < kHead) break;
    if (unsignedAt<3>(p + 7) != kTimesync) continue;
    const std::size_t payload = p[1], end = kHead + payload;
    if (left < end + kCrcSize) break;
    const std::uint16_t crc = crc16Mavlink(&kTimesyncCrc, 1, crc16Mavlink(p + 1, end - 1));
    if (crc != unsignedAt<2>(p + end)) continue;
    std::uint8_t whole[kTimesyncSize] = {};
    std::copy(p + kHead, p + end, whole);
    if (unsignedAt<8>(whole) == 0)
      asked.push_back(static_cast<std::int64_t>(unsignedAt<8>(whole + 8)));
    at += end + kCrcSize - 1;
  }
  pending_.erase(0, at);
  return asked;
}

}  // namespace vir::live
