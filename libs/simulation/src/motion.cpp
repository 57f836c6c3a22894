#include "vir/simulation/motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "vir/geometry/finite_pose.h"
#include "vir/types/interpolation.h"

namespace vir::simulation {
namespace {

/// Farther away nothing moves, and splines of it run out of numbers [m].
constexpr double kFarthestM = 1e12;

std::vector<Vec3> positions(const Trajectory& poses) {
  std::vector<Vec3> out;
  for (const StampedPose& s : poses) {
    if (!isFinite(s.T_W_B) || !(s.T_W_B.p.cwiseAbs().maxCoeff() < kFarthestM)) {
      throw std::invalid_argument("Motion: the pose at " + std::to_string(s.t) +
                                  " ns is no number, or farther away than anything moves");
    }
    out.push_back(s.T_W_B.p);
  }
  return out;
}

QuatList rotations(const Trajectory& poses) {
  QuatList out;
  for (const StampedPose& s : poses) out.push_back(s.T_W_B.q);
  return out;
}

/// Mean over `half_s` to either side with triangular weights.
Pose smoothed(const Trajectory& poses, TimeNs t, double half_s) {
  constexpr int kSide = 5;
  const Pose centre = heldPoseAt(poses, t);
  if (half_s <= 0) return centre;
  Vec3 p = Vec3::Zero(), turn = Vec3::Zero();
  double sum = 0;
  for (int k = -kSide; k <= kSide; ++k) {
    const double w = kSide + 1 - std::abs(k);
    const Pose s = heldPoseAt(poses, t + fromSeconds(half_s * k / (kSide + 1)));
    p += w * s.p;
    turn += w * logQuat(centre.q.conjugate() * s.q);
    sum += w;
  }
  return {(centre.q * expQuat(turn / sum)).normalized(), p / sum};
}

}  // namespace

Motion::Motion(TimeNs begin, double interval_s, const Trajectory& poses)
    : begin_(begin),
      end_(begin),
      position_(VectorSpline::through(interval_s, positions(poses))),
      rotation_(RotationSpline::through(interval_s, rotations(poses))) {
  end_ += fromSeconds(position_.duration());
}

MotionState Motion::at(TimeNs t) const {
  const double s = toSeconds(t - begin_);
  const VectorSplinePoint p = position_.at(s);
  const RotationSplinePoint r = rotation_.at(s);
  return {{r.q_A_B, p.value}, p.first, p.second, r.rate_B, r.acceleration_B};
}

Trajectory Motion::sampled(double rate_hz) const {
  Trajectory out;
  for (int k = 0;; ++k) {
    const TimeNs t = begin_ + fromSeconds(k / rate_hz);
    if (t > end_) return out;
    out.push_back({t, poseAt(t)});
  }
}

double Motion::pathLength() const {
  double length = 0;
  Vec3 last = poseAt(begin_).p;
  for (const StampedPose& s : sampled(50)) {
    length += (s.T_W_B.p - last).norm();
    last = s.T_W_B.p;
  }
  return length;
}

Motion flyAgain(const Trajectory& recorded, const FlyAgainOptions& options) {
  if (recorded.size() < 2) throw std::invalid_argument("flyAgain: fewer than 2 poses");
  const auto check = [](const char* name, double x, double least, double most) {
    if (x >= least && x <= most) return;
    throw std::invalid_argument(std::string("flyAgain: ") + name + " = " + std::to_string(x) +
                                " must be from " + std::to_string(least) + " to " +
                                std::to_string(most));
  };
  constexpr double kYears = 1e9;
  check("from_s", options.from_s, 0, kYears);
  check("duration_s", options.duration_s, 0, kYears);
  check("knot_s", options.knot_s, 0.001, 10);
  check("smooth_s", options.smooth_s, 0, 100);
  const TimeNs begin = recorded.front().t + fromSeconds(options.from_s);
  TimeNs end = recorded.back().t;
  if (options.duration_s > 0) end = std::min(end, begin + fromSeconds(options.duration_s));
  if (begin < recorded.front().t || toSeconds(end - begin) < 0.5) {
    throw std::invalid_argument("flyAgain: less than 0.5 s of the recording is left from " +
                                std::to_string(options.from_s) + " s on");
  }
  Trajectory samples;
  for (int k = 0;; ++k) {
    const TimeNs t = begin + fromSeconds(options.knot_s * k);
    if (t > end) break;
    samples.push_back({t, smoothed(recorded, t, options.smooth_s)});
  }
  return Motion(begin, options.knot_s, samples);
}

}  // namespace vir::simulation
