#include "vir/geometry/pose.h"

#include <cmath>
#include <stdexcept>

namespace vir {

double yawOf(const Mat3& R_W_B) { return std::atan2(R_W_B(1, 0), R_W_B(0, 0)); }

Mat3 rotZ(double yaw) {
  Mat3 R;
  R << std::cos(yaw), -std::sin(yaw), 0, std::sin(yaw), std::cos(yaw), 0, 0, 0, 1;
  return R;
}

Quat gravityAlignedAttitude(const Vec3& up_B) {
  const double n = up_B.norm();
  if (!(n > 0)) throw std::invalid_argument("gravityAlignedAttitude: the vector is zero");
  const Quat q = Quat::FromTwoVectors(up_B / n, Vec3::UnitZ());
  const Mat3 R = q.toRotationMatrix();
  return Quat(rotZ(-yawOf(R)) * R).normalized();
}

}  // namespace vir
