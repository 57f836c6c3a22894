#include "vir/geometry/so3.h"

#include <cmath>

namespace vir {
inline namespace geometry {

Mat3 hat(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Quat expQuat(const Vec3& theta) {
  const double sq = theta.squaredNorm();
  double c = 0.0;  // cos(|theta|/2)
  double s = 0.0;  // sin(|theta|/2) / |theta|
  if (sq < 1e-8) {
    c = 1.0 - sq / 8.0;
    s = 0.5 - sq / 48.0;
  } else {
    const double n = std::isfinite(sq) ? std::sqrt(sq) : theta.stableNorm();
    c = std::cos(0.5 * n);
    s = std::sin(0.5 * n) / n;
  }
  return Quat(c, s * theta.x(), s * theta.y(), s * theta.z()).normalized();
}

Mat3 expSO3(const Vec3& theta) { return expQuat(theta).toRotationMatrix(); }

Vec3 logQuat(const Quat& q) {
  // Of the two quaternions of a rotation, the one with w >= 0 gives the angle up to pi.
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const Vec3 v = sign * q.vec();
  const double n = v.norm();
  const double w = sign * q.w();
  if (n < 1e-6) return v * (2.0 / w) * (1.0 - n * n / (3.0 * w * w));
  return v * (2.0 * std::atan2(n, w) / n);
}

Vec3 logSO3(const Mat3& R) { return logQuat(Quat(R)); }

Mat3 rightJacobianSO3(const Vec3& theta) {
  const double sq = theta.squaredNorm();
  const Mat3 H = hat(theta);
  double a = 0.5;        // (1 - cos) / sq
  double b = 1.0 / 6.0;  // (n - sin) / n^3
  if (sq < 1e-6) {
    a -= sq / 24.0;
    b -= sq / 120.0;
  } else {
    const double n = std::sqrt(sq);
    a = (1.0 - std::cos(n)) / sq;
    b = (n - std::sin(n)) / (sq * n);
  }
  return Mat3::Identity() - a * H + b * H * H;
}

Mat3 rightJacobianInverseSO3(const Vec3& theta) {
  const double sq = theta.squaredNorm();
  const Mat3 H = hat(theta);
  double b = 1.0 / 12.0;
  if (sq < 1e-4) {
    b += sq / 720.0;
  } else {
    // 1/n^2 - (1 + cos)/(2 n sin), with half angles so that it stays finite at n = pi.
    const double n = std::sqrt(sq);
    b = (1.0 - 0.5 * n * std::cos(0.5 * n) / std::sin(0.5 * n)) / sq;
  }
  return Mat3::Identity() + 0.5 * H + b * H * H;
}

}  // namespace geometry
}  // namespace vir
