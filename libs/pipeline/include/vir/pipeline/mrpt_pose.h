#pragma once
/// MRPT's poses stop here.
#include <mrpt/poses/CPose3D.h>

#include <Eigen/Core>

#include "vir/geometry/pose.h"

namespace vir {

/// T_A_B of an MRPT pose that stands for B in A.
inline Pose fromMrptPose(const mrpt::poses::CPose3D& T) {
  const auto& R = T.getRotationMatrix();
  Mat3 M;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) M(r, c) = R(r, c);
  }
  return {Quat(M).normalized(), Vec3(T.x(), T.y(), T.z())};
}

}  // namespace vir
