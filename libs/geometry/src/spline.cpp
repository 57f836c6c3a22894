#include "vir/geometry/spline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace vir {
inline namespace geometry {
namespace {

/// Rounds towards an interpolating curve: each leaves at most 2/3 of the misfit, at the highest
/// frequency that the values can hold; far less of what is smooth.
constexpr int kRounds = 40;
/// Times are rounded to nanoseconds by callers.
constexpr double kTimeTolerance = 1e-6;

/// Weights of the differences between neighbouring control points, and their derivatives.
struct Basis {
  std::size_t piece = 0;
  double value[3], first[3], second[3];
};

Basis basisAt(double t_s, double interval_s, std::size_t controls) {
  const std::size_t pieces = controls - 3;
  const double end = interval_s * static_cast<double>(pieces);
  if (!(t_s >= -kTimeTolerance && t_s <= end + kTimeTolerance)) {
    throw std::out_of_range("spline: time " + std::to_string(t_s) + " s is outside 0 to " +
                            std::to_string(end) + " s");
  }
  const double x = std::clamp(t_s / interval_s, 0.0, static_cast<double>(pieces));
  Basis b;
  b.piece = std::min(static_cast<std::size_t>(x), pieces - 1);
  const double u = x - static_cast<double>(b.piece), h = interval_s;
  b.value[0] = (5 + u * (3 + u * (-3 + u))) / 6;
  b.value[1] = (1 + u * (3 + u * (3 - 2 * u))) / 6;
  b.value[2] = u * u * u / 6;
  b.first[0] = (1 - u) * (1 - u) / (2 * h);
  b.first[1] = (1 + 2 * u - 2 * u * u) / (2 * h);
  b.first[2] = u * u / (2 * h);
  b.second[0] = (u - 1) / (h * h);
  b.second[1] = (1 - 2 * u) / (h * h);
  b.second[2] = u / (h * h);
  return b;
}

void check(double interval_s, std::size_t controls) {
  // Its square and the square's inverse must be numbers.
  if (!(interval_s > 1e-100 && interval_s < 1e100))
    throw std::invalid_argument("spline: the interval must be positive");
  if (controls < 4) throw std::invalid_argument("spline: fewer than 4 control points");
}

}  // namespace

VectorSpline::VectorSpline(double interval_s, std::vector<Vec3> control)
    : interval_s_(interval_s), control_(std::move(control)) {
  check(interval_s_, control_.size());
}

VectorSplinePoint VectorSpline::at(double t_s) const {
  const Basis b = basisAt(t_s, interval_s_, control_.size());
  VectorSplinePoint out;
  out.value = control_[b.piece];
  for (std::size_t j = 0; j < 3; ++j) {
    const Vec3 step = control_[b.piece + j + 1] - control_[b.piece + j];
    out.value += b.value[j] * step;
    out.first += b.first[j] * step;
    out.second += b.second[j] * step;
  }
  return out;
}

VectorSpline VectorSpline::through(double interval_s, const std::vector<Vec3>& values) {
  const std::size_t n = values.size();
  if (n < 2) throw std::invalid_argument("spline: fewer than 2 values");
  std::vector<Vec3> inner = values;
  const auto complete = [&] {
    std::vector<Vec3> control(n + 2);
    std::copy(inner.begin(), inner.end(), control.begin() + 1);
    control[0] = 2 * inner[0] - inner[1];
    control[n + 1] = 2 * inner[n - 1] - inner[n - 2];
    return VectorSpline(interval_s, std::move(control));
  };
  for (int round = 0; round < kRounds; ++round) {
    const VectorSpline curve = complete();
    for (std::size_t k = 0; k < n; ++k) {
      inner[k] += values[k] - curve.at(interval_s * static_cast<double>(k)).value;
    }
  }
  return complete();
}

RotationSpline::RotationSpline(double interval_s, QuatList control)
    : interval_s_(interval_s), control_(std::move(control)) {
  check(interval_s_, control_.size());
  for (std::size_t k = 0; k + 1 < control_.size(); ++k) {
    steps_.push_back(logQuat(control_[k].conjugate() * control_[k + 1]));
  }
}

RotationSplinePoint RotationSpline::at(double t_s) const {
  const Basis b = basisAt(t_s, interval_s_, control_.size());
  RotationSplinePoint out;
  out.q_A_B = control_[b.piece];
  for (std::size_t j = 0; j < 3; ++j) {
    const Vec3& step = steps_[b.piece + j];
    const Quat turn = expQuat(b.value[j] * step);
    out.q_A_B = out.q_A_B * turn;
    out.rate_B = turn.conjugate() * out.rate_B + b.first[j] * step;
    out.acceleration_B = turn.conjugate() * out.acceleration_B + b.second[j] * step +
                         b.first[j] * out.rate_B.cross(step);
  }
  out.q_A_B.normalize();
  return out;
}

RotationSpline RotationSpline::through(double interval_s, const QuatList& values) {
  const std::size_t n = values.size();
  if (n < 2) throw std::invalid_argument("spline: fewer than 2 values");
  QuatList inner = values;
  const auto complete = [&] {
    QuatList control(n + 2);
    std::copy(inner.begin(), inner.end(), control.begin() + 1);
    control[0] = inner[0] * (inner[1].conjugate() * inner[0]);
    control[n + 1] = inner[n - 1] * (inner[n - 2].conjugate() * inner[n - 1]);
    return RotationSpline(interval_s, std::move(control));
  };
  for (int round = 0; round < kRounds; ++round) {
    const RotationSpline curve = complete();
    for (std::size_t k = 0; k < n; ++k) {
      const Quat now = curve.at(interval_s * static_cast<double>(k)).q_A_B;
      inner[k] = (inner[k] * expQuat(logQuat(now.conjugate() * values[k]))).normalized();
    }
  }
  return complete();
}

}  // namespace geometry
}  // namespace vir
