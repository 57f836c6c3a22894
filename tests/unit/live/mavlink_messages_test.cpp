/// What an autopilot is told: numbers by hand, and frames against those of another writer.
#include "vir/live/mavlink_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>

#include "vir/core/little_endian.h"
#include "vir_test_paths.h"
#include "vir_test_poses.h"

namespace vir::live {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;
constexpr double kQuarter = M_PI / 2;

std::string bytesOfHex(const std::string& hex) {
  std::string out;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    out += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return out;
}

/// Lines of frames.txt, in order.
std::vector<std::string> othersFrames() {
  std::ifstream in(test::sourceDir() + "/tests/fixtures/mavlink/frames.txt");
  std::vector<std::string> out;
  for (std::string name, hex; in >> name >> hex;) out.push_back(bytesOfHex(hex));
  return out;
}

/// The numbers of make_frames.cjs.
MavlinkPose othersPose() {
  MavlinkPose pose;
  pose.t = 1600000027990000999;  // microseconds are cut off
  pose.T_L_F = Pose(Quat(0.5, -0.5, 0.5, 0.5), Vec3(1.5, -2.25, -0.75));
  pose.v_F = Vec3(0.125, -1.5, 3);
  pose.rate_F = Vec3(-0.25, 0.5, 0.0625);
  Mat6 covariance;
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) {
      covariance(row, col) = row == col ? (row + 1) / 1024.0 : (row + col) / 8192.0;
    }
  }
  pose.covariance = covariance;
  pose.resets = 3;
  pose.quality = 100;
  return pose;
}

TEST(MavlinkEncoder, FramesAreThoseOfAnotherWriter) {
  const std::vector<std::string> expected = othersFrames();
  ASSERT_EQ(expected.size(), 5u);
  MavlinkEncoder encoder({7, 197});
  EXPECT_EQ(encoder.heartbeat(), expected[0]);
  EXPECT_EQ(encoder.odometry(othersPose()), expected[1]);
  MavlinkPose level = othersPose();
  level.T_L_F.q = Quat::Identity();
  level.covariance.reset();
  level.resets = 0;
  EXPECT_EQ(encoder.visionPosition(level), expected[2]);
  EXPECT_EQ(encoder.timesyncAnswer(1796024098367600490, 123456789), expected[3]);
}

TEST(TimesyncListener, AnswersQuestionsOnly) {
  const std::vector<std::string> frames = othersFrames();
  ASSERT_EQ(frames.size(), 5u);
  std::string stream = "\xFD\x12garbage\xFD";
  for (const std::string& frame : frames) stream += frame;
  stream += frames[4];
  std::string damaged = frames[4];
  damaged[12] ^= 1;
  stream += damaged + frames[4];
  TimesyncListener whole;
  const std::vector<std::int64_t> expected(3, 987654321987);
  EXPECT_EQ(whole.feed(bytesOf(stream), stream.size()), expected);
  TimesyncListener bytewise;
  std::vector<std::int64_t> found;
  for (const char c : stream) {
    const auto one = bytewise.feed(reinterpret_cast<const std::uint8_t*>(&c), 1);
    found.insert(found.end(), one.begin(), one.end());
  }
  EXPECT_EQ(found, expected);
}

/// Nose to the north (+x of W), 2 m up, climbing, rolled by nothing.
TEST(AutopilotPose, ForwardLeftUpBecomesForwardRightDown) {
  State state;
  state.t = 5;
  state.T_W_B = Pose(Quat::Identity(), Vec3(1, 2, 3));
  state.v = Vec3(4, 5, 6);
  const MavlinkPose pose = autopilotPose(state, Vec3(0.1, 0.2, 0.3), Mat6::Zero(), {});
  EXPECT_EQ(pose.T_L_F.p, Vec3(1, -2, -3));
  EXPECT_NEAR(pose.T_L_F.q.angularDistance(Quat::Identity()), 0, 1e-12);
  EXPECT_EQ(pose.v_F, Vec3(4, -5, -6));
  EXPECT_EQ(pose.rate_F, Vec3(0.1, -0.2, -0.3));
  EXPECT_FALSE(pose.covariance);
  // A turn to the left is one to a smaller heading.
  state.T_W_B.q = expQuat(Vec3(0, 0, kQuarter));
  const MavlinkPose left = autopilotPose(state, Vec3::Zero(), Mat6::Zero(), {});
  EXPECT_NEAR(rollPitchYaw(left.T_L_F.q).z(), -kQuarter, 1e-12);
  EXPECT_NEAR((left.v_F - Vec3(5, 4, -6)).norm(), 0, 1e-12);
}

TEST(AutopilotPose, CameraAxesAndALeverArm) {
  AutopilotMounting mounting;
  mounting.R_F_B = axesRotation("z x y");  // the body is the camera: x right, y down, z ahead
  mounting.p_B_F = Vec3(0, 0.5, -0.2);     // half a metre below, a bit behind
  State state;
  Mat3 R_W_B;  // looks along W's x, upright
  R_W_B << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  state.T_W_B = Pose(Quat(R_W_B), Vec3::Zero());
  const MavlinkPose pose = autopilotPose(state, Vec3(0, 2, 0), Mat6::Zero(), mounting);
  EXPECT_NEAR(rollPitchYaw(pose.T_L_F.q).norm(), 0, 1e-12);
  EXPECT_NEAR((pose.T_L_F.p - Vec3(-0.2, 0, 0.5)).norm(), 0, 1e-12);
  // A turn about "down" moves what is behind to the left.
  EXPECT_NEAR((pose.rate_F - Vec3(0, 0, 2)).norm(), 0, 1e-12);
  EXPECT_NEAR((pose.v_F - Vec3(0, -0.4, 0)).norm(), 0, 1e-12);
}

/// Against differences of the pose itself.
TEST(AutopilotPose, CovarianceIsThatOfPositionAndAngles) {
  AutopilotMounting mounting;
  mounting.p_B_F = Vec3(0.3, -0.1, 0.2);
  for (const vir_test::NamedPose& pose_of_test : vir_test::poses()) {
    SCOPED_TRACE(pose_of_test.name);
    const Pose& T = pose_of_test.T;
    State state;
    state.T_W_B = T;
    const auto coordinates = [&](const Eigen::Matrix<double, 6, 1>& error) {
      State moved = state;
      moved.T_W_B.p += error.head<3>();
      moved.T_W_B.q = T.q * expQuat(error.tail<3>());
      const MavlinkPose pose = autopilotPose(moved, Vec3::Zero(), Mat6::Zero(), mounting);
      Eigen::Matrix<double, 6, 1> out;
      out << pose.T_L_F.p, rollPitchYaw(pose.T_L_F.q);
      return out;
    };
    const Eigen::Matrix<double, 6, 1> zero = Eigen::Matrix<double, 6, 1>::Zero();
    if (std::abs(std::cos(coordinates(zero)[4])) < 0.05) continue;
    Mat6 J;
    for (int i = 0; i < 6; ++i) {
      Eigen::Matrix<double, 6, 1> step = zero;
      step[i] = 1e-6;
      Eigen::Matrix<double, 6, 1> change = coordinates(step) - coordinates(-step);
      for (int k = 3; k < 6; ++k) change[k] = std::remainder(change[k], 2 * M_PI);
      J.col(i) = change / 2e-6;
    }
    Mat6 covariance = Mat6::Identity() * 1e-4;
    covariance(0, 4) = covariance(4, 0) = 3e-5;
    covariance(3, 3) = 4e-4;
    const auto found = autopilotPose(state, Vec3::Zero(), covariance, mounting).covariance;
    ASSERT_TRUE(found);
    const Mat6 expected = J * covariance * J.transpose();
    EXPECT_LT((*found - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(RollPitchYaw, NoseStraightUp) {
  const Vec3 up = rollPitchYaw(expQuat(Vec3(0, 0, 0.7)) * expQuat(Vec3(0, kQuarter, 0)));
  EXPECT_NEAR(up.y(), kQuarter, 1e-6);
  EXPECT_NEAR(up.z() - up.x(), 0.7, 1e-6);
  State state;
  state.T_W_B.q = expQuat(Vec3(0, kQuarter, 0));
  const auto covariance = autopilotPose(state, Vec3::Zero(), Mat6::Identity(), {}).covariance;
  ASSERT_TRUE(covariance);
  EXPECT_TRUE(covariance->allFinite());
}

}  // namespace
}  // namespace vir::live
