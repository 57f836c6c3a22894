#include "moved_frame.h"

namespace vir::team {

void moveA(const WorldTransform& T_new_A, MutualRange* range) {
  const Mat3 R = rotZ(T_new_A.yaw_rad);
  range->p_A = T_new_A * range->p_A;
  range->cov_A = R * range->cov_A * R.transpose();
}

void moveA(const WorldTransform& T_new_A, SharedAnchor* anchor) {
  const Mat3 R = rotZ(T_new_A.yaw_rad);
  anchor->p_A = T_new_A * anchor->p_A;
  anchor->cov_A = R * anchor->cov_A * R.transpose();
}

void moveA(const WorldTransform& T_new_A, SharedPlaces* places) {
  places->T_A_B = T_new_A * places->T_A_B;
  places->T_A_B.yaw_rad = wrapAngle(places->T_A_B.yaw_rad);
  places->covariance = movedCovariance(T_new_A, places->covariance);
}

Eigen::Matrix4d movedCovariance(const WorldTransform& T_new_A, const Eigen::Matrix4d& covariance) {
  Eigen::Matrix4d J = Eigen::Matrix4d::Identity();
  J.bottomRightCorner<3, 3>() = rotZ(T_new_A.yaw_rad);
  return J * covariance * J.transpose();
}

void moveA(const WorldTransform& T_new_A, TransformAnswer* answer) {
  for (TransformSolution& s : answer->solutions) {
    s.T_A_B = T_new_A * s.T_A_B;
    s.T_A_B.yaw_rad = wrapAngle(s.T_A_B.yaw_rad);
    if (s.likelier_z_m) *s.likelier_z_m += T_new_A.t_m.z();
    s.covariance = movedCovariance(T_new_A, s.covariance);
  }
}

void move(const WorldTransform& T_new_A, KnownPose* pose) {
  pose->T_W_B = T_new_A.pose() * pose->T_W_B;
  // Rotations err on the right: they do not know of the world.
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Identity();
  J.topLeftCorner<3, 3>() = rotZ(T_new_A.yaw_rad);
  pose->covariance = J * pose->covariance * J.transpose();
}

}  // namespace vir::team
