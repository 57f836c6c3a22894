#pragma once
/// MRPT's poses stop here.
#include <Eigen/Core>
//
#include <mrpt/math/CQuaternion.h>
#include <mrpt/poses/CPose3D.h>

#include "vir/geometry/pose.h"

namespace vir::rawlog {

/// T_A_B of an MRPT pose that stands for B in A.
inline Pose fromMrptPose(const mrpt::poses::CPose3D& T) {
  const auto& R = T.getRotationMatrix();
  Mat3 M;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) M(r, c) = R(r, c);
  }
  return {Quat(M).normalized(), Vec3(T.x(), T.y(), T.z())};
}

inline mrpt::poses::CPose3D toMrptPose(const Pose& T) {
  return {mrpt::math::CQuaternionDouble(T.q.w(), T.q.x(), T.q.y(), T.q.z()), T.p.x(), T.p.y(),
          T.p.z()};
}

}  // namespace vir::rawlog
