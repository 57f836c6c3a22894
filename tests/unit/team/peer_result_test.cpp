#include "vir/team/peer_result.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vir::team {
namespace {

PeerResult placed(double yaw_rad, const Vec3& t) {
  PeerResult peer;
  TransformSolution s;
  s.T_A_B = {yaw_rad, t};
  s.covariance.setZero();
  s.covariance.diagonal() << 1e-4, 0.04, 0.09, 0.16;
  s.covariance(0, 1) = s.covariance(1, 0) = 1e-3;
  peer.transform.answer.status = TransformStatus::unique;
  peer.transform.answer.solutions = {s};
  KnownPose told;
  told.t = 5;
  told.T_W_B = {Quat(Eigen::AngleAxisd(0.3, Vec3::UnitX())), Vec3(10, 0, 1)};
  told.covariance.setZero();
  told.covariance.diagonal() << 0.01, 0.02, 0.03, 0, 0, 0;
  peer.told = told;
  return peer;
}

TEST(PoseInOwnWorld, IsThatOfTheTransform) {
  const auto there = poseInOwnWorld(placed(0.5 * M_PI, Vec3(1, 2, 3)));
  ASSERT_TRUE(there);
  EXPECT_EQ(there->t, 5);
  EXPECT_LT((there->T_W_B.p - Vec3(1, 12, 4)).norm(), 1e-12);
  EXPECT_NEAR(yawOf(there->T_W_B.R()), 0.5 * M_PI, 1e-12);
}

TEST(PoseInOwnWorld, KnowsHowSureItIs) {
  const auto there = poseInOwnWorld(placed(0.5 * M_PI, Vec3(1, 2, 3)));
  ASSERT_TRUE(there);
  // It is 10 m along y: a turn moves it along -x. The told x is y here.
  const auto& C = there->covariance;
  EXPECT_NEAR(C(0, 0), 0.04 + 100 * 1e-4 - 2 * 10 * 1e-3 + 0.02, 1e-12);
  EXPECT_NEAR(C(1, 1), 0.09 + 0.01, 1e-12);
  EXPECT_NEAR(C(2, 2), 0.16 + 0.03, 1e-12);
  // About the vertical, wherever that is in its body.
  const Vec3 up = there->T_W_B.q.conjugate() * Vec3::UnitZ();
  const Mat3 turned = C.bottomRightCorner(3, 3);
  EXPECT_NEAR(up.dot(turned * up), 1e-4, 1e-12);
  EXPECT_NEAR(turned.trace(), 1e-4, 1e-12);
}

TEST(PoseInOwnWorld, IsEmptyWhileNothingIsSure) {
  PeerResult peer = placed(0, Vec3::Zero());
  peer.transform.answer.status = TransformStatus::ambiguous;
  EXPECT_FALSE(poseInOwnWorld(peer));
  peer = placed(0, Vec3::Zero());
  peer.told.reset();
  EXPECT_FALSE(poseInOwnWorld(peer));
}

}  // namespace
}  // namespace vir::team
