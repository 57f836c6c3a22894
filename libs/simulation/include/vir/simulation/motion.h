#pragma once
/// The true motion of a simulated body: a spline, so that poses, rates and accelerations belong
/// together exactly and any recorded trajectory can be flown again.
#include "vir/evaluation/trajectory.h"
#include "vir/geometry/spline.h"

namespace vir::simulation {

struct MotionState {
  Pose T_W_B;
  Vec3 v_W = Vec3::Zero();             ///< [m/s]
  Vec3 a_W = Vec3::Zero();             ///< [m/s^2]
  Vec3 rate_B = Vec3::Zero();          ///< angular rate in the body frame [rad/s]
  Vec3 acceleration_B = Vec3::Zero();  ///< angular, in the body frame [rad/s^2]
};

/// World W has z up. Twice continuously differentiable.
class Motion {
 public:
  /// Through pose k (T_W_B) at `begin + k * interval_s`. At least 2 poses; neighbours less than pi
  /// apart. Throws std::invalid_argument.
  Motion(TimeNs begin, double interval_s, const Trajectory& poses);

  TimeNs begin() const { return begin_; }
  TimeNs end() const { return end_; }
  double duration() const { return toSeconds(end_ - begin_); }
  /// Throws std::out_of_range for a time outside [begin(), end()].
  MotionState at(TimeNs t) const;
  Pose poseAt(TimeNs t) const { return at(t).T_W_B; }
  /// Poses from begin() to end() at a rate [Hz].
  Trajectory sampled(double rate_hz) const;
  /// Length of the path [m], measured at 50 Hz.
  double pathLength() const;

 private:
  TimeNs begin_, end_;
  VectorSpline position_;
  RotationSpline rotation_;
};

struct FlyAgainOptions {
  double from_s = 0;      ///< after the first pose
  double duration_s = 0;  ///< 0 = to the last pose
  double knot_s = 0.05;   ///< distance of the spline's knots
  /// The recorded poses are averaged over this long to either side (triangular weights): noise of
  /// the recording would become vibration.
  double smooth_s = 0.05;
};

/// Flies a recorded trajectory (T_W_B, W with z up). Gaps are filled by interpolation. The result
/// is near the recording, not on it: it is the truth of the simulation. Throws
/// std::invalid_argument for options that are no numbers or none that make a flight (a knot every
/// ms to every 10 s), and when the recording has fewer than 2 poses or less than 0.5 s is left.
Motion flyAgain(const Trajectory& recorded, const FlyAgainOptions& options);

}  // namespace vir::simulation
