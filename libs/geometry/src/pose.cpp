#include "vir/geometry/pose.h"

#include <cmath>
#include <stdexcept>

namespace vir {
inline namespace geometry {

double yawOf(const Mat3& R_W_B) { return std::atan2(R_W_B(1, 0), R_W_B(0, 0)); }

double nearestYaw(const Mat3& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

Mat3 rotZ(double yaw) {
  Mat3 R;
  R << std::cos(yaw), -std::sin(yaw), 0, std::sin(yaw), std::cos(yaw), 0, 0, 0, 1;
  return R;
}

Quat gravityAlignedAttitude(const Vec3& up_B) {
  const double n = up_B.norm();
  if (!(n > 0)) throw std::invalid_argument("gravityAlignedAttitude: the vector is zero");
  // Rows of R_W_B are W's axes in B: z is up, and without yaw y has no part along B's x. This keeps
  // all digits upside down too, where the shortest turn between two vectors loses them.
  const Vec3 z = up_B / n;
  Vec3 y(0, z.z(), -z.y());
  const double across = y.norm();
  y = across > 0 ? Vec3(y / across) : Vec3::UnitY();
  Mat3 R;
  R.row(0) = y.cross(z);
  R.row(1) = y;
  R.row(2) = z;
  return Quat(R).normalized();
}

}  // namespace geometry
}  // namespace vir
