#pragma once
#include "vir/types/state.h"

namespace vir {
inline namespace types {

/// The covariance of a pose with its rotations about the axes of W, as ROS has them; `covariance`
/// is of (position in W [m], rotation on the right [rad]), about the axes of the body.
inline Eigen::Matrix<double, 6, 6> fixedAxesCovariance(
    const Pose& T_W_B, const Eigen::Matrix<double, 6, 6>& covariance) {
  Eigen::Matrix<double, 6, 6> turned = Eigen::Matrix<double, 6, 6>::Identity();
  turned.bottomRightCorner<3, 3>() = T_W_B.q.toRotationMatrix();
  return turned * covariance * turned.transpose();
}

}  // namespace types
}  // namespace vir
