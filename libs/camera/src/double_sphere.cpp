#include <cmath>

#include "models.h"

namespace vir::camera {

namespace {
constexpr double kTolerancePx = 0.01;
}  // namespace

DoubleSphereCamera::DoubleSphereCamera(const CameraCalibration& c)
    : CameraModel(c), xi_(c.dist[0]), alpha_(c.dist[1]) {
  // Beyond this angle two directions have one pixel (equations 43 to 45 of the model's paper).
  const double w1 = alpha_ <= 0.5 ? alpha_ / (1.0 - alpha_) : (1.0 - alpha_) / alpha_;
  min_z_ = -(w1 + xi_) / std::sqrt(2.0 * w1 * xi_ + xi_ * xi_ + 1.0);
}

bool DoubleSphereCamera::project(const Vec3& p, Vec2* px, Mat23* J) const {
  const auto& c = calibration_;
  *px = Vec2(c.cx, c.cy);
  if (J != nullptr) J->setZero();
  const double length = p.norm();
  if (!std::isfinite(length) || !(length > 1e-150)) return false;
  const Vec3 b = p / length;
  if (!(b.z() > min_z_)) return false;
  const Vec3 q(b.x(), b.y(), b.z() + xi_);  // from the centre of the second sphere
  const double d2 = q.norm();
  const double w = alpha_ * d2 + (1.0 - alpha_) * q.z();
  if (!(w > 1e-9)) return false;
  const Vec2 m = b.head<2>() / w;
  *px = Vec2(c.fx * m.x() + c.cx, c.fy * m.y() + c.cy);
  if (J != nullptr) {
    const Eigen::RowVector3d dz1 = Eigen::RowVector3d::UnitZ() + xi_ * b.transpose();
    const Eigen::RowVector3d dd2 = (Eigen::RowVector3d(q.x(), q.y(), 0.0) + q.z() * dz1) / d2;
    const Eigen::RowVector3d dw = alpha_ * dd2 + (1.0 - alpha_) * dz1;
    J->row(0) = c.fx * (Eigen::RowVector3d::UnitX() - m.x() * dw) / (w * length);
    J->row(1) = c.fy * (Eigen::RowVector3d::UnitY() - m.y() * dw) / (w * length);
  }
  return true;
}

bool DoubleSphereCamera::unproject(const Vec2& px, Vec3* bearing) const {
  *bearing = Vec3::UnitZ();
  if (!px.allFinite()) return false;
  const auto& c = calibration_;
  const Vec2 m((px.x() - c.cx) / c.fx, (px.y() - c.cy) / c.fy);
  const double r2 = m.squaredNorm();
  const double under = 1.0 - (2.0 * alpha_ - 1.0) * r2;
  if (!(under > 0.0)) return false;
  const double mz = (1.0 - alpha_ * alpha_ * r2) / (alpha_ * std::sqrt(under) + 1.0 - alpha_);
  const double under2 = mz * mz + (1.0 - xi_ * xi_) * r2;
  if (!(under2 > 0.0)) return false;
  const double along = (mz * xi_ + std::sqrt(under2)) / (mz * mz + r2);
  const Vec3 b(along * m.x(), along * m.y(), along * mz - xi_);
  Vec2 again;
  if (!b.allFinite() || !(b.norm() > 0.0) || !project(b, &again, nullptr)) return false;
  *bearing = b.normalized();
  return (again - px).norm() < kTolerancePx;
}

}  // namespace vir::camera
