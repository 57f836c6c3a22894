#include "vir/team/closed_form.h"

#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"

namespace vir::team {

YawPair yawsFromRange(const MutualRange& range, const SharedAnchor& anchor) {
  YawPair out;
  const Vec3 a = range.p_A - anchor.p_A, b = range.p_B - anchor.p_B;
  const double rho_a = a.head<2>().norm(), rho_b = b.head<2>().norm();
  const double scale = rho_a * rho_b;
  if (!(scale > 0) || !std::isfinite(scale)) {
    out.problem = YawProblem::on_the_vertical;
    return out;
  }
  // |a - R b|^2 = |a|^2 + |b|^2 - 2 a.(R b): the law of cosines with the heights taken off.
  const double cosine =
      (a.squaredNorm() + b.squaredNorm() - range.range_m * range.range_m - 2 * a.z() * b.z()) /
      (2 * scale);
  // What the range's own error moves the cosine by.
  const double slack = 3 * range.range_m * range.sigma_m / scale;
  if (slack > 1) {
    out.problem = YawProblem::on_the_vertical;
    return out;
  }
  if (!(std::abs(cosine) <= 1 + slack)) {
    out.problem = YawProblem::does_not_fit;
    return out;
  }
  const double middle = std::atan2(a.y(), a.x()) - std::atan2(b.y(), b.x());
  const double half = std::acos(std::clamp(cosine, -1.0, 1.0));
  out.problem = YawProblem::none;
  out.yaw_rad = {wrapAngle(middle + half), wrapAngle(middle - half)};
  return out;
}

WorldTransform throughAnchor(double yaw_rad, const SharedAnchor& anchor) {
  return {yaw_rad, anchor.p_A - rotZ(yaw_rad) * anchor.p_B};
}

double wrapAngle(double angle_rad) {
  const double a = std::remainder(angle_rad, 2 * kPi);
  return a <= -kPi ? a + 2 * kPi : a;
}

}  // namespace vir::team
