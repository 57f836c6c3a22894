#pragma once
/// Uniform cubic B-splines over time, in R^3 and on SO(3), with derivatives: twice continuously
/// differentiable, each piece depends on four control points.
#include <Eigen/StdVector>
#include <vector>

#include "vir/geometry/so3.h"

namespace vir {
inline namespace geometry {

struct VectorSplinePoint {
  Vec3 value = Vec3::Zero();
  Vec3 first = Vec3::Zero();   ///< d/dt [1/s]
  Vec3 second = Vec3::Zero();  ///< d2/dt2 [1/s^2]
};

struct RotationSplinePoint {
  Quat q_A_B = Quat::Identity();
  Vec3 rate_B = Vec3::Zero();          ///< angular rate of B against A, in B [rad/s]
  Vec3 acceleration_B = Vec3::Zero();  ///< its derivative [rad/s^2]
};

class VectorSpline {
 public:
  /// A curve from 0 to `interval_s * (control.size() - 3)` seconds; control point k pulls hardest
  /// at time (k - 1) * interval_s. Throws std::invalid_argument for fewer than 4 control points or
  /// an interval that is not positive.
  VectorSpline(double interval_s, std::vector<Vec3> control);
  /// The curve that passes through value k at k * interval_s, not bent at its ends (natural
  /// spline). At least 2 values.
  static VectorSpline through(double interval_s, const std::vector<Vec3>& values);

  double duration() const { return interval_s_ * static_cast<double>(control_.size() - 3); }
  /// Throws std::out_of_range for a time outside [0, duration()].
  VectorSplinePoint at(double t_s) const;

 private:
  double interval_s_;
  std::vector<Vec3> control_;
};

using QuatList = std::vector<Quat, Eigen::aligned_allocator<Quat>>;

/// Cumulative form (Kim et al. 1995); derivatives by the recursion of Sommer et al. 2020
/// ("Efficient derivative computation for cumulative B-splines on Lie groups"). Neighbouring
/// control rotations must be less than pi apart.
class RotationSpline {
 public:
  /// As VectorSpline.
  RotationSpline(double interval_s, QuatList control_A_B);
  /// The curve that passes through rotation k at k * interval_s, with constant rate at its ends.
  static RotationSpline through(double interval_s, const QuatList& q_A_B);

  double duration() const { return interval_s_ * static_cast<double>(control_.size() - 3); }
  RotationSplinePoint at(double t_s) const;

 private:
  double interval_s_;
  QuatList control_;
  std::vector<Vec3> steps_;  ///< rotation vector from control k to k + 1
};

}  // namespace geometry
}  // namespace vir
