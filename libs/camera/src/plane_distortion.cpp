#include <cmath>

#include "models.h"

namespace vir::camera {

namespace {

// 89.4 deg from the axis: nearer to the image plane a pinhole projection means nothing.
constexpr double kMaxRadius = 100.0;

}  // namespace

PlaneDistortion::PlaneDistortion(const std::array<double, 5>& d)
    : k_{d[0], d[1], d[2], d[3], d[4], 0, 0, 0}, rational_(false) {
  r_max_ = turningPoint({d[0], d[1], d[4]}, kMaxRadius);
}

PlaneDistortion::PlaneDistortion(const std::array<double, 8>& d) : k_(d), rational_(true) {
  r_max_ = positiveUpTo(
      [this](double r) {
        const double r2 = r * r;
        const double below = 1.0 + r2 * (k_[5] + r2 * (k_[6] + r2 * k_[7]));
        double slope = 0.0;
        const double factor = radial(r2, &slope);
        // Up to the first pole only, whatever is behind it.
        return below > 0.0 && factor > 0.0 ? factor + r2 * slope : -1.0;
      },
      kMaxRadius);
}

double PlaneDistortion::radial(double r2, double* slope) const {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = k_;
  const double factor = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  *slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
  if (!rational_) return factor;
  const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double below_slope = 2.0 * (k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6));
  const double quotient = factor / below;
  *slope = (*slope - quotient * below_slope) / below;
  return quotient;
}

Vec2 PlaneDistortion::distort(const Vec2& m, Eigen::Matrix2d* D) const {
  const double p1 = k_[2], p2 = k_[3];
  const double x = m.x(), y = m.y();
  const double r2 = x * x + y * y;
  double slope = 0.0;
  const double factor = radial(r2, &slope);
  if (D != nullptr) {
    const double cross = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    (*D)(0, 0) = factor + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
    (*D)(0, 1) = cross;
    (*D)(1, 0) = cross;
    (*D)(1, 1) = factor + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * factor + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * factor + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

bool PlaneDistortion::invert(const Vec2& target, const Vec2& scale, double tolerance,
                             Vec2* m) const {
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
  return Vec2(scale.x() * error.x(), scale.y() * error.y()).norm() < tolerance &&
         D.determinant() > 0.0;
}

}  // namespace vir::camera
