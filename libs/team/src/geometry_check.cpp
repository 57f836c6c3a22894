#include "geometry_check.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace vir::team {
namespace {

using Vec2 = Eigen::Vector2d;

/// Sideways, as a share of the length, what still counts as a straight line.
constexpr double kStraight = 0.02;

struct Shape {
  double length = 0, width = 0;  ///< twice the root mean square along the main axes [m]
};

/// Horizontal, about the mean, or about a point.
Shape shapeOf(const std::vector<Vec2>& points, const Vec2* about) {
  Vec2 centre = Vec2::Zero();
  if (about != nullptr) {
    centre = *about;
  } else {
    for (const Vec2& p : points) centre += p / static_cast<double>(points.size());
  }
  Eigen::Matrix2d C = Eigen::Matrix2d::Zero();
  for (const Vec2& p : points) {
    C += (p - centre) * (p - centre).transpose() / static_cast<double>(points.size());
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(C, Eigen::EigenvaluesOnly);
  const Vec2 e = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  return {2 * e[1], 2 * e[0]};
}

bool straight(const Shape& s, double sigma) {
  return s.width <= std::max(kStraight * s.length, 0.1 * sigma);
}

std::string who(bool a, bool b) {
  if (a && b) return "both robots";
  return a ? "robot A" : "robot B";
}

}  // namespace

GeometryProblem geometryProblem(const std::vector<MutualRange>& ranges,
                                const SharedAnchor* anchor) {
  std::vector<Vec2> a, b;
  double sigma = ranges.front().sigma_m;
  for (const MutualRange& m : ranges) {
    a.push_back(m.p_A.head<2>());
    b.push_back(m.p_B.head<2>());
    sigma = std::min(sigma, m.sigma_m);
  }
  const Shape path_a = shapeOf(a, nullptr), path_b = shapeOf(b, nullptr);
  const double still = 2 * sigma;
  const bool still_a = path_a.length < still, still_b = path_b.length < still;
  if (anchor != nullptr) {
    const Vec2 at_a = anchor->p_A.head<2>(), at_b = anchor->p_B.head<2>();
    const Shape about_a = shapeOf(a, &at_a), about_b = shapeOf(b, &at_b);
    const bool above_a = about_a.length < 4 * sigma, above_b = about_b.length < 4 * sigma;
    if (above_a || above_b) {
      return {who(above_a, above_b) + " on the vertical of the anchor: move away from it", false};
    }
    if (still_a && still_b) {
      return {"neither robot moves: one of them must, and not on a line through the anchor", true};
    }
    if (straight(about_a, sigma) && straight(about_b, sigma)) {
      return {"both robots stay on a straight line through the anchor: leave it sideways", true};
    }
    return {};
  }
  if (still_a && still_b) return {"neither robot moves: both must", false};
  if (still_a || still_b) {
    return {who(still_a, still_b) + " does not move: without an anchor both must", false};
  }
  if (straight(path_a, sigma) && straight(path_b, sigma)) {
    return {"both robots move on straight lines: make a turn", true};
  }
  return {};
}

}  // namespace vir::team
