#include "vir/team/peer_result.h"

namespace vir::team {

std::optional<KnownPose> poseInOwnWorld(const PeerResult& peer) {
  const TransformAnswer& answer = peer.transform.answer;
  if (answer.status != TransformStatus::unique || !peer.told) return std::nullopt;
  const TransformSolution& s = answer.solutions[0];
  KnownPose out = *peer.told;
  out.T_W_B = s.T_A_B.pose() * peer.told->T_W_B;
  const Mat3 R = rotZ(s.T_A_B.yaw_rad);
  // By yaw, x, y, z of the transform.
  Eigen::Matrix<double, 6, 4> J = Eigen::Matrix<double, 6, 4>::Zero();
  J.block<3, 1>(0, 0) = Vec3::UnitZ().cross(R * peer.told->T_W_B.p);
  J.block<3, 3>(0, 1).setIdentity();
  J.block<3, 1>(3, 0) = out.T_W_B.q.conjugate() * Vec3::UnitZ();
  Eigen::Matrix<double, 6, 6> turned = Eigen::Matrix<double, 6, 6>::Identity();
  turned.topLeftCorner<3, 3>() = R;
  out.covariance =
      J * s.covariance * J.transpose() + turned * peer.told->covariance * turned.transpose();
  return out;
}

}  // namespace vir::team
