#pragma once
/// What is known of a pair once A's poses go on in another frame: `T_new_A` takes the old to it.
#include "vir/team/find_transform.h"
#include "vir/team/robot_record.h"

namespace vir::team {

void moveA(const WorldTransform& T_new_A, MutualRange* range);
void moveA(const WorldTransform& T_new_A, SharedAnchor* anchor);
void moveA(const WorldTransform& T_new_A, SharedPlaces* places);
void moveA(const WorldTransform& T_new_A, TransformAnswer* answer);
/// Of (yaw, x, y, z) of a T_A_B.
Eigen::Matrix4d movedCovariance(const WorldTransform& T_new_A, const Eigen::Matrix4d& covariance);
/// A pose of A's own.
void move(const WorldTransform& T_new_A, KnownPose* pose);

}  // namespace vir::team
