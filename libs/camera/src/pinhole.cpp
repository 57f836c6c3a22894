#include <cmath>

#include "models.h"

namespace vir::camera {

namespace {
// 89.4 deg from the axis: nearer to the image plane a pinhole projection means nothing.
constexpr double kMaxRadius = 100.0;
}  // namespace

PinholeCamera::PinholeCamera(const CameraCalibration& c) : CameraModel(c) {
  if (c.distortion == Distortion::none) calibration_.dist.fill(0.0);
  const auto& d = calibration_.dist;
  r_max_ = turningPoint({d[0], d[1], d[4]}, kMaxRadius);
}

Vec2 PinholeCamera::distort(const Vec2& m, Eigen::Matrix2d* D) const {
  const auto& [k1, k2, p1, p2, k3] = calibration_.dist;
  const double x = m.x(), y = m.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (D != nullptr) {
    const double slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));  // (d radial / d r2) * 2
    const double cross = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    (*D)(0, 0) = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
    (*D)(0, 1) = cross;
    (*D)(1, 0) = cross;
    (*D)(1, 1) = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

bool PinholeCamera::project(const Vec3& p, Vec2* px, Mat23* J) const {
  const auto& c = calibration_;
  *px = Vec2(c.cx, c.cy);
  if (J != nullptr) J->setZero();
  if (!p.allFinite() || !(p.z() > 0.0)) return false;
  // Compared before dividing, so that a tiny z cannot overflow.
  if (!(p.head<2>().norm() < r_max_ * p.z())) return false;
  const double iz = 1.0 / p.z();
  const Vec2 m = p.head<2>() * iz;
  if (!m.allFinite()) return false;
  Eigen::Matrix2d D;
  const Vec2 d = distort(m, &D);
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

bool PinholeCamera::invert(const Vec2& target, Vec2* m) const {
  if (calibration_.distortion == Distortion::none) {
    *m = target;
    return m->norm() < r_max_;
  }
  // Newton with the step halved while it leaves the model's range or does not come nearer.
  *m = target;
  if (m->norm() >= r_max_) *m *= 0.5 * r_max_ / m->norm();
  Eigen::Matrix2d D;
  Vec2 error = target - distort(*m, &D);
  double best = error.norm();
  for (int i = 0; i < 50 && best > 0.0; ++i) {
    if (!(D.determinant() > 0.0)) return false;
    Vec2 step = D.inverse() * error;
    bool improved = false;
    for (int half = 0; half < 12 && !improved; ++half, step *= 0.5) {
      const Vec2 candidate = *m + step;
      if (!(candidate.norm() < r_max_)) continue;
      Eigen::Matrix2d candidate_D;
      const Vec2 candidate_error = target - distort(candidate, &candidate_D);
      if (!(candidate_error.norm() < best)) continue;
      *m = candidate;
      D = candidate_D;
      error = candidate_error;
      best = error.norm();
      improved = true;
    }
    if (!improved) break;  // at the limit of the arithmetic, or no solution
  }
  const auto& c = calibration_;
  return Vec2(c.fx * error.x(), c.fy * error.y()).norm() < 0.01 && D.determinant() > 0.0;
}

bool PinholeCamera::unproject(const Vec2& px, Vec3* bearing) const {
  *bearing = Vec3::UnitZ();
  if (!px.allFinite()) return false;
  const auto& c = calibration_;
  Vec2 m;
  if (!invert(Vec2((px.x() - c.cx) / c.fx, (px.y() - c.cy) / c.fy), &m)) return false;
  *bearing = Vec3(m.x(), m.y(), 1.0).normalized();
  return true;
}

}  // namespace vir::camera
