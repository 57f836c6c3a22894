#pragma once
/// What figures of trajectories have in common.
#include <vector>

#include "vir/evaluation/figure.h"

namespace vir::evaluation {

/// Colours told apart with any colour vision (the palette of Okabe and Ito); comes round after 6.
Color figureColor(std::size_t i);

/// Cuts a sequence where its stamps are more than `hole` apart. `stamp(i)` and `value(i)` for i in
/// 0..n-1.
template <typename Stamp, typename Value>
std::vector<std::vector<Vec2>> cutAtHoles(std::size_t n, TimeNs hole, Stamp stamp, Value value) {
  std::vector<std::vector<Vec2>> strokes;
  for (std::size_t i = 0; i < n; ++i) {
    if (i == 0 || stamp(i) - stamp(i - 1) > hole) strokes.emplace_back();
    strokes.back().push_back(value(i));
  }
  return strokes;
}

/// Time between neighbours beyond which a sequence counts as interrupted: 0.5 s, or five times the
/// usual interval where that is more.
TimeNs holeOf(const Trajectory& trajectory);

/// The path projected on two axes (0 = x, 1 = y, 2 = z).
std::vector<std::vector<Vec2>> pathStrokes(const Trajectory& trajectory, int a, int b, TimeNs hole);

/// The horizontal axis along which the path reaches further: 0 = x, 1 = y.
int longerHorizontalAxis(const Trajectory& trajectory);

/// Closed outline of the points that are `sigmas` standard deviations from `centre`; only finite
/// numbers, whatever the covariance.
std::vector<Vec2> ellipseOutline(const Vec2& centre, const Eigen::Matrix2d& covariance,
                                 double sigmas);

}  // namespace vir::evaluation
