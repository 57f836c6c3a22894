#include "vir/ranging/next_waypoint.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"

namespace vir::ranging {
namespace {

constexpr double kSteps_m[] = {0.5, 1, 1.5, 2, 3, 5, 8};
/// There may be a ceiling.
constexpr double kHighest_m = 3;
/// Less told is not worth a step, as a share of what is sufficient.
constexpr double kWorthIt = 1.0 / 3;

/// Up first: of two steps that tell the same, the first is taken.
std::vector<Vec3> directions() {
  std::vector<Vec3> out{Vec3::UnitZ()};
  constexpr int kLevel = 8;
  for (int i = 0; i < kLevel; ++i) {
    const double angle = 2 * kPi * i / kLevel;
    out.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  out.push_back(-Vec3::UnitZ());
  return out;
}

/// Where the anchor may be: each as far away as its hypothesis is.
std::vector<Vec3> pointsInQuestion(const Vec3& from_W, const std::vector<AnchorHypothesis>& all) {
  std::vector<Vec3> out;
  for (const AnchorHypothesis& h : all) {
    const double distance = (h.p_W - from_W).norm();
    if (!std::isfinite(distance) || distance > 1e6 || !h.covariance.allFinite()) continue;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(h.covariance);
    for (int i = 0; i < 3; ++i) {
      const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()[i]));
      for (const double side : {1.0, -1.0}) {
        const Vec3 p =
            h.p_W + side * std::min(std::sqrt(3.0) * sigma, 1e6) * eigen.eigenvectors().col(i);
        const double away = (p - from_W).norm();
        if (away > 0) out.emplace_back(from_W + distance / away * (p - from_W));
      }
    }
  }
  return out;
}

/// Standard deviation over the points of how much nearer `to_W` is to them than `from_W`.
double told(const Vec3& from_W, const Vec3& to_W, const std::vector<Vec3>& points) {
  double sum = 0, squares = 0;
  for (const Vec3& p : points) {
    const double change = (p - to_W).norm() - (p - from_W).norm();
    sum += change;
    squares += change * change;
  }
  const double n = static_cast<double>(points.size());
  return std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)));
}

}  // namespace

std::optional<Waypoint> nextWaypoint(const Vec3& from_W,
                                     const std::vector<AnchorHypothesis>& hypotheses,
                                     double sufficient_m, double lowest_z_m) {
  if (!from_W.allFinite() || !(sufficient_m > 0)) return std::nullopt;
  const std::vector<Vec3> points = pointsInQuestion(from_W, hypotheses);
  if (points.empty()) return std::nullopt;
  const std::vector<Vec3> ways = directions();
  Waypoint best;
  for (const double length : kSteps_m) {
    for (const Vec3& way : ways) {
      const double rise = length * way.z();
      if (std::abs(rise) > kHighest_m || (rise < 0 && from_W.z() + rise < lowest_z_m)) continue;
      const double here = told(from_W, from_W + length * way, points);
      // By a thousandth at least: what differs by rounding only is the same.
      if (here > 1.001 * best.told_m) best = {length * way, here};
    }
    if (best.told_m >= sufficient_m) return best;
  }
  if (best.told_m < kWorthIt * sufficient_m) return std::nullopt;
  return best;
}

}  // namespace vir::ranging
