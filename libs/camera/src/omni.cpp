#include <cmath>

#include "models.h"

namespace vir::camera {

namespace {

constexpr double kTolerancePx = 0.01;
/// Points of the plane farther out than this are seen at grazing angles only.
constexpr double kSmallestDepth = 1e-2;

PlaneDistortion planeOf(const CameraCalibration& c) {
  const auto& d = c.dist;
  return PlaneDistortion(std::array<double, 5>{d[1], d[2], d[3], d[4], 0.0});
}

}  // namespace

OmniCamera::OmniCamera(const CameraCalibration& c)
    : CameraModel(c), xi_(c.dist[0]), plane_(planeOf(c)) {}

bool OmniCamera::project(const Vec3& p, Vec2* px, Mat23* J) const {
  const auto& c = calibration_;
  *px = Vec2(c.cx, c.cy);
  if (J != nullptr) J->setZero();
  const double length = p.norm();
  if (!std::isfinite(length) || !(length > 1e-150)) return false;
  const Vec3 b = p / length;
  // With xi > 1 the sphere hides its far side: what is seen ends where the ray touches it.
  const double w = b.z() + xi_;
  if (!(w > kSmallestDepth) || (xi_ > 1.0 && !(b.z() * xi_ > -1.0))) return false;
  const Vec2 m = b.head<2>() / w;
  if (!(m.norm() < plane_.rMax())) return false;
  Eigen::Matrix2d D;
  const Vec2 d = plane_.distort(m, &D);
  if (!(D.determinant() > 0.0)) return false;
  *px = Vec2(c.fx * d.x() + c.cx, c.fy * d.y() + c.cy);
  if (J != nullptr) {
    // m = (x, y) / (z + xi |p|), differentiated at |p| = 1.
    const Eigen::RowVector3d dw = Eigen::RowVector3d::UnitZ() + xi_ * b.transpose();
    Mat23 dm = -m * dw;
    dm(0, 0) += 1.0;
    dm(1, 1) += 1.0;
    D.row(0) *= c.fx;
    D.row(1) *= c.fy;
    *J = D * dm / (w * length);
  }
  return true;
}

bool OmniCamera::unproject(const Vec2& px, Vec3* bearing) const {
  *bearing = Vec3::UnitZ();
  if (!px.allFinite()) return false;
  const auto& c = calibration_;
  Vec2 m;
  const Vec2 target((px.x() - c.cx) / c.fx, (px.y() - c.cy) / c.fy);
  if (!plane_.invert(target, Vec2(c.fx, c.fy), kTolerancePx, &m)) return false;
  // Where the ray (m, 1) from xi behind the centre meets the sphere.
  const double r2 = m.squaredNorm();
  const double under = 1.0 + (1.0 - xi_ * xi_) * r2;
  if (!(under > 0.0)) return false;
  const double along = (xi_ + std::sqrt(under)) / (1.0 + r2);
  const Vec3 b(along * m.x(), along * m.y(), along - xi_);
  Vec2 again;
  if (!b.allFinite() || !project(b.normalized(), &again, nullptr)) return false;
  *bearing = b.normalized();
  return (again - px).norm() < kTolerancePx;
}

}  // namespace vir::camera
