#include "vir/geometry/level_transform.h"

#include <cmath>

namespace vir {
inline namespace geometry {
namespace {

/// Points whose horizontal spread is below this have no direction [m].
constexpr double kNoSpread = 1e-3;

}  // namespace

Vec3 LevelFit::swing(const Vec3& p_B) const {
  const Vec3 arm = rotZ(T_A_B.yaw_rad) * (p_B - centre_B);
  return {-arm.y(), arm.x(), 0};
}

LevelFit fitLevel(const std::vector<LevelPair>& pairs) {
  LevelFit fit;
  Vec3 centre_A = Vec3::Zero();
  for (const LevelPair& p : pairs) {
    fit.weight += p.weight;
    fit.centre_B += p.weight * p.p_B;
    centre_A += p.weight * p.p_A;
  }
  if (!(fit.weight > 0)) return LevelFit();
  fit.centre_B /= fit.weight;
  centre_A /= fit.weight;
  double cosine = 0, sine = 0;
  for (const LevelPair& p : pairs) {
    const Vec3 a = p.p_A - centre_A, b = p.p_B - fit.centre_B;
    cosine += p.weight * a.head<2>().dot(b.head<2>());
    sine += p.weight * (a.y() * b.x() - a.x() * b.y());
    fit.turn += p.weight * b.head<2>().squaredNorm();
  }
  fit.turn_known = fit.turn > fit.weight * kNoSpread * kNoSpread && std::hypot(cosine, sine) > 0;
  if (fit.turn_known) fit.T_A_B.yaw_rad = std::atan2(sine, cosine);
  fit.T_A_B.t_m = centre_A - rotZ(fit.T_A_B.yaw_rad) * fit.centre_B;
  for (const LevelPair& p : pairs) fit.cost += p.weight * (fit.T_A_B * p.p_B - p.p_A).squaredNorm();
  return fit;
}

}  // namespace geometry
}  // namespace vir
