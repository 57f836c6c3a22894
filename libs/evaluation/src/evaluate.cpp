#include "vir/evaluation/evaluate.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <sstream>

#include "vir/core/angles.h"
#include "vir/core/time_bounds.h"
#include "vir/evaluation/leaps.h"

namespace vir::evaluation {
namespace {

double angleDeg(const Quat& q) { return kDegPerRad * logQuat(q).norm(); }

/// Angle of the part of `q` that turns about z (swing-twist) in -180..180.
double twistAboutZDeg(const Quat& q) {
  const double angle = 2.0 * std::atan2(q.z(), q.w());
  return kDegPerRad * std::remainder(angle, 2 * kPi);
}

void checkOverlap(const Trajectory& reference, const Trajectory& estimate,
                  const Association& association) {
  if (reference.empty()) throw EvaluationError("the reference holds no pose");
  if (estimate.empty()) throw EvaluationError("the estimate holds no pose");
  if (association.pairs.size() >= 3) return;
  std::ostringstream text;
  text << association.pairs.size() << " of " << estimate.size()
       << " poses of the estimate have a reference, at least 3 are needed: " << association.before
       << " before and " << association.after << " after the reference, " << association.in_gap
       << " in gaps of it. Reference " << formatSeconds(reference.front().t) << " to "
       << formatSeconds(reference.back().t) << " s, estimate " << formatSeconds(estimate.front().t)
       << " to " << formatSeconds(estimate.back().t) << " s: check that both use the same clock";
  throw EvaluationError(text.str());
}

/// A tracker of positions writes the same attitude always, whatever the body does.
bool attitudesMeanSomething(const std::vector<PosePair>& pairs) {
  constexpr double kMovedM = 0.1, kTurnedDeg = 45;
  const PosePair& first = pairs.front();
  double moved = 0, turned = 0, least_tilt = 180;
  for (const PosePair& pair : pairs) {
    if (pair.reference.q.coeffs() != first.reference.q.coeffs()) return true;
    moved = std::max(moved, (pair.reference.p - first.reference.p).norm());
    turned = std::max(turned, angleDeg(first.estimate.q.conjugate() * pair.estimate.q));
    // Where each of the two has up in the body.
    const Vec3 up_r = pair.reference.q.conjugate() * Vec3::UnitZ();
    const Vec3 up_e = pair.estimate.q.conjugate() * Vec3::UnitZ();
    least_tilt =
        std::min(least_tilt, kDegPerRad * std::acos(std::clamp(up_r.dot(up_e), -1.0, 1.0)));
  }
  return moved < kMovedM || (turned < kTurnedDeg && least_tilt < kTurnedDeg);
}

/// Travelled reference path up to each pair [m].
std::vector<double> pathLengths(const std::vector<PosePair>& pairs) {
  std::vector<double> path(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    path[i] = path[i - 1] + (pairs[i].reference.p - pairs[i - 1].reference.p).norm();
  }
  return path;
}

std::vector<double> timesOf(const std::vector<PosePair>& pairs) {
  std::vector<double> times;
  for (const PosePair& pair : pairs)
    times.push_back(toSeconds(timeBetween(pairs.front().t, pair.t)));
  return times;
}

/// Pieces of `length` on the measure `at` (path or time, not decreasing).
RelativeError relativeError(const EvaluationResult& result, const std::vector<double>& at,
                            double length, bool by_distance) {
  RelativeError error;
  error.length = length;
  std::vector<double> translation, percent, rotation, yaw;
  // Stamps and sums of steps are rounded: half a microunit is no reason to take the next pose.
  const double tolerance = 1e-6;
  std::size_t j = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    j = std::max(j, i + 1);
    while (j < at.size() && at[j] - at[i] < length - tolerance) ++j;
    if (j >= at.size()) break;
    const double travelled = at[j] - at[i];
    if (travelled > 1.25 * length) continue;
    const Pose& r_i = result.association.pairs[i].reference;
    const Pose& r_j = result.association.pairs[j].reference;
    const Pose& e_i = result.aligned[i];
    const Pose& e_j = result.aligned[j];
    const Pose E = (r_i.inverse() * r_j).inverse() * (e_i.inverse() * e_j);
    translation.push_back(E.p.norm());
    if (by_distance) percent.push_back(100.0 * E.p.norm() / travelled);
    rotation.push_back(angleDeg(E.q));
    // The same error turned into the world, where the vertical is z whatever the body's axes are.
    yaw.push_back(std::abs(twistAboutZDeg(r_j.q * E.q * r_j.q.conjugate())));
  }
  error.translation_m = statisticsOf(translation);
  error.translation_pct = statisticsOf(percent);
  error.rotation_deg = statisticsOf(rotation);
  error.yaw_deg = statisticsOf(yaw);
  return error;
}

void absoluteErrors(EvaluationResult* result) {
  for (const PosePair& pair : result->association.pairs) {
    const Pose T = result->transform.apply(pair.estimate);
    result->aligned.push_back(T);
    result->position_error_m.push_back((T.p - pair.reference.p).norm());
    const double angle = angleDeg(pair.reference.q.conjugate() * T.q);
    result->orientation_error_deg.push_back(result->attitudes ? angle : 0);
  }
  result->ate_position_m = statisticsOf(result->position_error_m);
  if (result->attitudes) result->ate_orientation_deg = statisticsOf(result->orientation_error_deg);
}

bool areNumbers(const Statistics& s) { return std::isfinite(s.rmse) && std::isfinite(s.max); }

bool areNumbers(const RelativeError& e) {
  return areNumbers(e.translation_m) && areNumbers(e.translation_pct) &&
         areNumbers(e.rotation_deg) && areNumbers(e.yaw_deg);
}

/// An error of inf, or a scale of NaN, would look like a result.
void requireNumbers(const EvaluationResult& r) {
  bool good = areNumbers(r.ate_position_m) && areNumbers(r.ate_orientation_deg) &&
              areNumbers(r.rpe_time) && r.transform.T_R_E.p.allFinite();
  for (const RelativeError& e : r.rpe_distance) good = good && areNumbers(e);
  for (const double x :
       {r.transform.scale, r.best_scale, r.path_m, r.end_error_m, r.end_to_start_m}) {
    good = good && std::isfinite(x);
  }
  if (good) return;
  throw EvaluationError(
      "positions are so far away that their errors are no numbers: look into the estimate and the "
      "reference for values that cannot be metres");
}

void endErrors(EvaluationResult* result) {
  result->end_error_m = result->position_error_m.back();
  const PosePair& first = result->association.pairs.front();
  const PosePair& last = result->association.pairs.back();
  if (!result->attitudes) return;
  const Pose E = (first.reference.inverse() * last.reference).inverse() *
                 (result->aligned.front().inverse() * result->aligned.back());
  result->end_to_start_m = E.p.norm();
}

}  // namespace

EvaluationResult evaluate(const Trajectory& given, const Trajectory& estimate,
                          const EvaluationOptions& options) {
  EvaluationResult result;
  const Trajectory reference = withoutLeaps(given, &result.reference_left_out);
  result.alignment = options.alignment;
  result.association = associate(reference, estimate, options.association);
  checkOverlap(reference, estimate, result.association);
  result.attitudes = !options.positions_only && attitudesMeanSomething(result.association.pairs);
  result.transform = align(result.association.pairs, options.alignment);
  const AlignmentResult similar = align(result.association.pairs, Alignment::sim3);
  result.best_scale = similar.note.find("scale") == std::string::npos ? similar.scale : 0;
  absoluteErrors(&result);
  endErrors(&result);
  const std::vector<double> path = pathLengths(result.association.pairs);
  result.path_m = path.back();
  for (const double d : options.distances_m) {
    if (d <= 0) continue;
    result.rpe_distance.emplace_back();
    result.rpe_distance.back().length = d;
    if (result.attitudes) result.rpe_distance.back() = relativeError(result, path, d, true);
  }
  result.rpe_time.length = options.rpe_time_s;
  if (options.rpe_time_s > 0 && result.attitudes) {
    result.rpe_time =
        relativeError(result, timesOf(result.association.pairs), options.rpe_time_s, false);
  }
  requireNumbers(result);
  return result;
}

Trajectory inWorldOfEstimate(const Trajectory& reference, const EvaluationResult& result) {
  const Pose T_E_R = result.transform.apply(Pose()).inverse();
  Trajectory out = reference;
  for (StampedPose& p : out) p.T_W_B = T_E_R * p.T_W_B;
  return out;
}

std::string describeComparison(const EvaluationOptions& options) {
  std::ostringstream text;
  switch (options.alignment) {
    case Alignment::none:
      text << "not aligned";
      break;
    case Alignment::posyaw:
      text << "aligned in position and yaw (4-DoF)";
      break;
    case Alignment::se3:
      text << "aligned in position and rotation (SE3)";
      break;
    case Alignment::sim3:
      text << "aligned in position, rotation and scale (Sim3)";
      break;
  }
  text << "; reference interpolated at the estimate's stamps, a sparse one the other way round "
          "(gaps "
          "up to "
       << std::setprecision(3) << toSeconds(options.association.max_gap) << " s)";
  return text.str();
}

}  // namespace vir::evaluation
