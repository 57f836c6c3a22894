#include "vir/geometry/interpolation.h"

namespace vir {
inline namespace geometry {

Pose interpolate(const Pose& a, const Pose& b, double s) {
  // slerp of Eigen takes the shorter way round.
  return {a.q.slerp(s, b.q).normalized(), a.p + s * (b.p - a.p)};
}

}  // namespace geometry
}  // namespace vir
