#pragma once
/// What a window estimates of the camera beside its pose in the body: eight numbers, all small, so
/// that a sight's bearing depends on them to first order.
#include <Eigen/Core>

#include "vir/geometry/pose.h"

namespace vir::factors {

/// Order of the camera's parameters.
enum CameraParameter {
  kTimeOffset,  ///< stamp of an image + offset = its time on the IMU's clock [s]
  kReadout,     ///< time from the first row of an image to the last [s]
  kFocal,       ///< relative change of both focal lengths
  kAspect,      ///< relative change of fx, and of fy the other way
  kCx,          ///< change of the principal point [px]
  kCy,
  kRadial1,  ///< change of the first radial coefficient (types::radialCoefficients)
  kRadial2,
};
constexpr int kCameraParameters = 8;

using CameraVector = Eigen::Matrix<double, kCameraParameters, 1>;
using CameraJacobian = Eigen::Matrix<double, 3, kCameraParameters>;

/// A bearing as it was seen, and how it changes with the camera's parameters.
struct CameraRay {
  Vec3 bearing = Vec3::UnitZ();                       ///< unit, camera frame, at `at`
  CameraJacobian by_camera = CameraJacobian::Zero();  ///< d bearing / d parameters
  CameraVector at = CameraVector::Zero();

  /// Not a unit vector where the parameters differ from `at`.
  Vec3 bearingAt(const CameraVector& parameters) const {
    return bearing + by_camera * (parameters - at);
  }
};

/// d bearing / d parameters of what was seen at `px` [px], `rate` = d bearing / dt [1/s]. `row` is
/// its row as a fraction of the image's height from the middle, -0.5 to 0.5: the row in the middle
/// is seen at the image's time. `dpx_dbearing`: projection Jacobian; `centre`: principal point.
/// `radial`: relative change of the pixel's distance from there per unit of either radial
/// coefficient.
CameraJacobian bearingByCamera(const Vec2& px, const Mat23& dpx_dbearing, const Vec3& rate,
                               const Vec2& centre, double row, const Vec2& radial);

}  // namespace vir::factors
