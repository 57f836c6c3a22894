#include <cmath>

#include "models.h"

namespace vir::camera {

namespace {

constexpr double kTolerancePx = 0.01;

PlaneDistortion planeOf(const CameraCalibration& c) {
  const auto& d = c.dist;
  if (c.distortion == Distortion::rational) return PlaneDistortion(d);
  if (c.distortion == Distortion::none) return PlaneDistortion(std::array<double, 5>{});
  return PlaneDistortion(std::array<double, 5>{d[0], d[1], d[2], d[3], d[4]});
}

}  // namespace

PinholeCamera::PinholeCamera(const CameraCalibration& c) : CameraModel(c), plane_(planeOf(c)) {
  if (c.distortion == Distortion::none) calibration_.dist.fill(0.0);
}

bool PinholeCamera::project(const Vec3& p, Vec2* px, Mat23* J) const {
  const auto& c = calibration_;
  *px = Vec2(c.cx, c.cy);
  if (J != nullptr) J->setZero();
  if (!p.allFinite() || !(p.z() > 0.0)) return false;
  // Compared before dividing, so that a tiny z cannot overflow.
  if (!(p.head<2>().norm() < plane_.rMax() * p.z())) return false;
  const double iz = 1.0 / p.z();
  const Vec2 m = p.head<2>() * iz;
  if (!m.allFinite()) return false;
  Eigen::Matrix2d D;
  const Vec2 d = plane_.distort(m, &D);
  // Tangential terms can fold the image as well, a little before the radial turning point.
  if (!(D.determinant() > 0.0)) return false;
  *px = Vec2(c.fx * d.x() + c.cx, c.fy * d.y() + c.cy);
  if (J != nullptr && std::isfinite(iz)) {
    D.row(0) *= c.fx;
    D.row(1) *= c.fy;
    J->leftCols<2>() = D * iz;
    J->col(2) = -J->leftCols<2>() * m;
  }
  return true;
}

bool PinholeCamera::unproject(const Vec2& px, Vec3* bearing) const {
  *bearing = Vec3::UnitZ();
  if (!px.allFinite()) return false;
  const auto& c = calibration_;
  const Vec2 target((px.x() - c.cx) / c.fx, (px.y() - c.cy) / c.fy);
  Vec2 m = target;
  const bool found = c.distortion == Distortion::none
                         ? m.norm() < plane_.rMax()
                         : plane_.invert(target, Vec2(c.fx, c.fy), kTolerancePx, &m);
  if (!found) return false;
  *bearing = Vec3(m.x(), m.y(), 1.0).normalized();
  return true;
}

}  // namespace vir::camera
