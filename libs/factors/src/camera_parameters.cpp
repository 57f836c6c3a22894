#include "vir/factors/camera_parameters.h"

#include <Eigen/LU>

namespace vir::factors {

CameraJacobian bearingByCamera(const Vec2& px, const Mat23& dpx_dbearing, const Vec3& rate,
                               const Vec2& centre, double row, const Vec2& radial) {
  // The pixel stays where it was seen; what moves is the ray through it. The projection Jacobian
  // knows nothing along the ray, so that its pseudo-inverse moves the bearing across it.
  const Eigen::Matrix<double, 3, 2> by_px =
      dpx_dbearing.transpose() * (dpx_dbearing * dpx_dbearing.transpose()).inverse();
  const Vec2 off = px - centre;
  CameraJacobian J;
  J.col(kTimeOffset) = -rate;
  J.col(kReadout) = -row * rate;
  J.col(kFocal) = -by_px * off;
  J.col(kAspect) = -by_px * Vec2(off.x(), -off.y());
  J.col(kCx) = -by_px.col(0);
  J.col(kCy) = -by_px.col(1);
  J.col(kRadial1) = radial.x() * J.col(kFocal);
  J.col(kRadial2) = radial.y() * J.col(kFocal);
  return J;
}

}  // namespace vir::factors
