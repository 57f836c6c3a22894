#include <algorithm>
#include <cmath>

#include "models.h"
#include "vir/core/angles.h"

namespace vir::camera {

namespace {
constexpr double kMaxTheta = 170.0 * kPi / 180.0;
}  // namespace

EquidistantCamera::EquidistantCamera(const CameraCalibration& c) : CameraModel(c) {
  const auto& d = c.dist;
  theta_max_ = turningPoint({d[0], d[1], d[2], d[3]}, kMaxTheta);
}

double EquidistantCamera::radius(double theta, double* slope) const {
  const auto& k = calibration_.dist;
  const double u = theta * theta;
  *slope = 1.0 + u * (3.0 * k[0] + u * (5.0 * k[1] + u * (7.0 * k[2] + u * 9.0 * k[3])));
  return theta * (1.0 + u * (k[0] + u * (k[1] + u * (k[2] + u * k[3]))));
}

bool EquidistantCamera::project(const Vec3& p, Vec2* px, Mat23* J) const {
  const auto& c = calibration_;
  *px = Vec2(c.cx, c.cy);
  if (J != nullptr) J->setZero();
  const double length = p.norm();
  if (!std::isfinite(length) || !(length > 1e-150)) return false;
  const double x = p.x() / length, y = p.y() / length, z = p.z() / length;
  const double r = std::hypot(x, y);
  const double theta = std::atan2(r, z);
  if (!(theta < theta_max_)) return false;
  double slope = 0.0;
  const double rho = radius(theta, &slope);
  // s = rho / r, and q such that ds/dx = x q, ds/dy = y q; series where r is too small to divide
  // by. ds/dz needs no series: it is -slope at unit length.
  double s = 0.0;
  double q = 0.0;
  if (r > 1e-4) {
    s = rho / r;
    q = (slope * z - s) / (r * r);
  } else {
    const double iz = 1.0 / z;
    const double k = c.dist[0] - 1.0 / 3.0;
    s = iz * (1.0 + k * r * r * iz * iz);
    q = 2.0 * k * iz * iz * iz;
  }
  *px = Vec2(c.fx * s * x + c.cx, c.fy * s * y + c.cy);
  if (J != nullptr) {
    *J << c.fx * (s + x * x * q), c.fx * x * y * q, -c.fx * x * slope,  //
        c.fy * x * y * q, c.fy * (s + y * y * q), -c.fy * y * slope;
    *J /= length;
  }
  return true;
}

bool EquidistantCamera::unproject(const Vec2& px, Vec3* bearing) const {
  *bearing = Vec3::UnitZ();
  if (!px.allFinite()) return false;
  const auto& c = calibration_;
  const Vec2 d((px.x() - c.cx) / c.fx, (px.y() - c.cy) / c.fy);
  const double rho = d.norm();
  if (rho < 1e-15) return true;
  // The radius grows all the way to theta_max_: Newton, kept inside a shrinking bracket.
  double slope = 0.0;
  double lo = 0.0, hi = theta_max_;
  if (!(rho < radius(hi, &slope))) return false;
  double theta = rho < hi ? rho : 0.5 * hi;
  for (int i = 0; i < 100; ++i) {
    const double error = rho - radius(theta, &slope);
    const double step = error / slope;
    if (std::abs(step) <= 4e-16 * theta) break;
    (error > 0.0 ? lo : hi) = theta;
    const double next = theta + step;
    theta = next > lo && next < hi ? next : 0.5 * (lo + hi);
  }
  if (!(std::abs(rho - radius(theta, &slope)) * std::max(c.fx, c.fy) < 0.01)) return false;
  const double sine = std::sin(theta) / rho;
  *bearing = Vec3(sine * d.x(), sine * d.y(), std::cos(theta)).normalized();
  return true;
}

}  // namespace vir::camera
