#include "vir/evaluation/figure_parts.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"

namespace vir::evaluation {

Color figureColor(std::size_t i) {
  static const std::array<Color, 6> colors{Color{0, 114, 178}, Color{213, 94, 0},
                                           Color{0, 158, 115}, Color{204, 121, 167},
                                           Color{230, 159, 0}, Color{86, 180, 233}};
  return colors[i % colors.size()];
}

TimeNs holeOf(const Trajectory& trajectory) {
  constexpr TimeNs kLeast = 500000000;
  if (trajectory.size() < 3) return kLeast;
  std::vector<TimeNs> steps;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    steps.push_back(trajectory[i].t - trajectory[i - 1].t);
  }
  return std::max(kLeast, 5 * medianInPlace(&steps));
}

std::vector<std::vector<Vec2>> pathStrokes(const Trajectory& trajectory, int a, int b,
                                           TimeNs hole) {
  return cutAtHoles(
      trajectory.size(), hole, [&](std::size_t i) { return trajectory[i].t; },
      [&](std::size_t i) { return Vec2(trajectory[i].T_W_B.p[a], trajectory[i].T_W_B.p[b]); });
}

int longerHorizontalAxis(const Trajectory& trajectory) {
  if (trajectory.empty()) return 0;
  Vec2 low = trajectory.front().T_W_B.p.head<2>(), high = low;
  for (const StampedPose& pose : trajectory) {
    low = low.cwiseMin(pose.T_W_B.p.head<2>());
    high = high.cwiseMax(pose.T_W_B.p.head<2>());
  }
  return high.x() - low.x() >= high.y() - low.y() ? 0 : 1;
}

std::vector<Vec2> ellipseOutline(const Vec2& centre, const Eigen::Matrix2d& covariance,
                                 double sigmas) {
  constexpr int kPoints = 72;
  std::vector<Vec2> outline;
  if (!centre.allFinite() || !covariance.allFinite()) return outline;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const Vec2 axes = sigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2 * kPi * (i % kPoints) / kPoints;
    const Vec2 p(axes.x() * std::cos(angle), axes.y() * std::sin(angle));
    outline.push_back(centre + solver.eigenvectors() * p);
  }
  return outline;
}

}  // namespace vir::evaluation
