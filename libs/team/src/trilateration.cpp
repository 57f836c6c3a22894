#include "trilateration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace vir::team {
namespace {

constexpr int kRounds = 3;  // of reweighting
/// Variance along an axis as a share of that along the longest, above which mirror images at the
/// plane (the ring around the line) need not be looked at.
constexpr double kFlat = 0.05, kThin = 0.02;
constexpr double kKnownAxis = 1e-9;  // [m^2], variance along an axis that is solved for at all

/// Where the robot stands by squared ranges: the mean of the points seen from, the axes of their
/// spread, shortest first, and the coordinate along each.
struct LinearFit {
  Vec3 mean, spread, coordinate;
  Mat3 axes;
  double rest = 0;  ///< [m^2] squared distance from the mean

  Vec3 position() const { return mean + axes * coordinate; }
};

LinearFit fitSquares(const std::vector<Vec3>& q, const std::vector<double>& weight,
                     const std::vector<MutualRange>& ranges) {
  const std::size_t n = q.size();
  LinearFit fit;
  double sum = 0, mean_target = 0;
  fit.mean.setZero();
  for (std::size_t k = 0; k < n; ++k) {
    fit.mean += weight[k] * q[k];
    sum += weight[k];
  }
  fit.mean /= sum;
  std::vector<double> target(n);
  Mat3 C = Mat3::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3 c = q[k] - fit.mean;
    target[k] = c.squaredNorm() - ranges[k].range_m * ranges[k].range_m;
    mean_target += weight[k] / sum * target[k];
    C += weight[k] / sum * c * c.transpose();
  }
  // |c - s|^2 = d^2: 2 c.s = |c|^2 - d^2 + |s|^2, whose mean takes |s|^2 away.
  Vec3 right = Vec3::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    right += (0.5 * weight[k] / sum) * (target[k] - mean_target) * (q[k] - fit.mean);
  }
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(C);
  fit.axes = eigen.eigenvectors();
  fit.spread = eigen.eigenvalues();
  for (int i = 0; i < 3; ++i) {
    fit.coordinate[i] = fit.spread[i] > kKnownAxis ? fit.axes.col(i).dot(right) / fit.spread[i] : 0;
  }
  fit.rest = -mean_target;  // |s|^2
  return fit;
}

}  // namespace

std::array<std::optional<Vec3>, Trilateration::kBranches> Trilateration::solve(
    double yaw_rad) const {
  const std::size_t n = ranges_.size();
  const Mat3 R = rotZ(yaw_rad);
  // Seen from A's world moved along with B: A's antenna is at q, and t is a fixed point.
  std::vector<Vec3> q(n);
  std::vector<double> weight(n);
  for (std::size_t k = 0; k < n; ++k) {
    q[k] = ranges_[k].p_A - R * ranges_[k].p_B;
    const double d = std::max(ranges_[k].range_m, 0.1);
    weight[k] = 1 / (d * d);  // the error of a squared range grows with it
  }
  LinearFit fit = fitSquares(q, weight, ranges_);
  for (int round = 1; round < kRounds; ++round) {
    const Vec3 t = fit.position();
    for (std::size_t k = 0; k < n; ++k) {
      const double d = std::max(ranges_[k].range_m, 0.1);
      const double e = (ranges_[k].range_m - (q[k] - t).norm()) / (0.1 * d + 0.1);
      weight[k] = 1 / (d * d * (1 + e * e));
    }
    fit = fitSquares(q, weight, ranges_);
  }
  const auto& [mean, spread, coordinate, axes, rest] = fit;
  std::array<std::optional<Vec3>, kBranches> out;
  out[0] = fit.position();
  if (spread[0] > kFlat * spread[2]) return out;
  const Vec3 up = axes.col(0), side = axes.col(1), along = axes.col(2);
  const double in_plane = coordinate[1] * coordinate[1] + coordinate[2] * coordinate[2];
  const double height = std::sqrt(std::max(0.0, rest - in_plane));
  const Vec3 foot = mean + side * coordinate[1] + along * coordinate[2];
  out[1] = foot + height * up;
  out[2] = foot - height * up;
  if (spread[1] > kThin * spread[2]) return out;
  const double radius = std::sqrt(std::max(0.0, rest - coordinate[2] * coordinate[2]));
  const Vec3 on_line = mean + along * coordinate[2];
  out[3] = on_line + radius * side;
  out[4] = on_line - radius * side;
  out[5] = on_line + radius * up;
  out[6] = on_line - radius * up;
  return out;
}

}  // namespace vir::team
