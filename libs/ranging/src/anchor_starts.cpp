#include "anchor_starts.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"
#include "vir/core/random.h"

namespace vir::ranging {
namespace {

constexpr int kSubsets = 24;
constexpr std::size_t kSubsetSize = 8;
constexpr int kRingPoints = 8;
/// An axis along which the path is shorter than this says nothing about the anchor [m].
constexpr double kNoExtent = 1e-4;

/// |q|^2 - 2 q.x + |x|^2 = z^2 with q, x relative to the path's centre is linear in x and m =
/// |x|^2. Solved for the `dims` leading axes of the path; what is left of m then is the squared
/// distance from the plane or the line of motion.
bool linearSolution(const FitData& data, const std::vector<std::size_t>& chosen,
                    const PathShape& shape, int dims, Vec3* x, double* rest) {
  Mat4 A = Mat4::Zero();
  Vec4 rhs = Vec4::Zero();
  for (const std::size_t i : chosen) {
    const Vec3 q = shape.axes.transpose() * (data.p[i] - shape.centre);
    Vec4 row = Vec4::Zero();
    for (int k = 0; k < dims; ++k) row[k] = -2 * q[k];
    row[3] = 1;
    const double y = data.z[i] * data.z[i] - q.squaredNorm();
    const double weight = 1 / std::max(2 * data.z[i] * data.sigma[i], 1e-9);
    A += weight * weight * row * row.transpose();
    rhs += weight * weight * y * row;
  }
  for (int k = dims; k < 3; ++k) A(k, k) = std::max(A(3, 3), 1e-300);
  const Eigen::LDLT<Mat4> ldlt(A);
  const Vec4 s = ldlt.solve(rhs);
  if (!s.allFinite() || s.norm() > 1e7) return false;
  *x = s.head<3>();
  for (int k = dims; k < 3; ++k) (*x)[k] = 0;
  *rest = s[3] - x->squaredNorm();
  return true;
}

void addStarts(const FitData& data, const std::vector<std::size_t>& chosen, const PathShape& shape,
               std::vector<Vec3>* out) {
  Vec3 x;
  double rest = 0;
  const auto add = [&](const Vec3& local) { out->push_back(shape.centre + shape.axes * local); };
  if (shape.deviation[2] > kNoExtent && linearSolution(data, chosen, shape, 3, &x, &rest)) {
    add(x);
    add({x[0], x[1], -x[2]});
  }
  if (shape.deviation[1] > kNoExtent && linearSolution(data, chosen, shape, 2, &x, &rest)) {
    const double h = std::sqrt(std::max(rest, 0.0));
    for (const double sign : {-1.0, 1.0}) add({x[0], x[1], sign * std::max(h, 1e-3)});
  }
  if (shape.deviation[0] > kNoExtent && linearSolution(data, chosen, shape, 1, &x, &rest)) {
    const double radius = std::sqrt(std::max(rest, 1e-6));
    for (int k = 0; k < kRingPoints; ++k) {
      const double angle = (k + 0.5) * 2 * kPi / kRingPoints;
      add({x[0], radius * std::cos(angle), radius * std::sin(angle)});
    }
  }
}

}  // namespace

PathShape pathShape(const std::vector<Vec3>& path) {
  PathShape shape;
  if (path.empty()) return shape;
  for (const Vec3& p : path) shape.centre += p / static_cast<double>(path.size());
  Mat3 S = Mat3::Zero();
  for (const Vec3& p : path) {
    S += (p - shape.centre) * (p - shape.centre).transpose() / static_cast<double>(path.size());
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(S);
  for (int k = 0; k < 3; ++k) {
    shape.axes.col(k) = eigen.eigenvectors().col(2 - k);
    shape.deviation[k] = std::sqrt(std::max(eigen.eigenvalues()[2 - k], 0.0));
    double low = 0, high = 0;
    for (const Vec3& p : path) {
      const double along = shape.axes.col(k).dot(p - shape.centre);
      low = std::min(low, along);
      high = std::max(high, along);
    }
    shape.extent[k] = high - low;
  }
  return shape;
}

std::vector<FitState> startPositions(const RangeFit& fit, const PathShape& shape,
                                     std::size_t count) {
  const FitData& data = fit.data();
  std::vector<Vec3> points;
  std::vector<std::size_t> all(data.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  addStarts(data, all, shape, &points);
  Random random(20200601);
  for (int k = 0; k < kSubsets && data.size() > 2 * kSubsetSize; ++k) {
    // One of each stretch of the path, so that a subset spans all of it.
    std::vector<std::size_t> subset;
    for (std::size_t j = 0; j < kSubsetSize; ++j) {
      const std::size_t from = j * data.size() / kSubsetSize;
      const std::size_t to = (j + 1) * data.size() / kSubsetSize;
      subset.push_back(from + random.below(to - from));
    }
    addStarts(data, subset, shape, &points);
  }

  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t i = 0; i < points.size(); ++i) ranked.push_back({fit.cost({points[i], 0}), i});
  std::sort(ranked.begin(), ranked.end());
  std::vector<FitState> starts;
  double distance = 0;
  for (const double z : data.z) distance += z / static_cast<double>(data.size());
  for (const auto& item : ranked) {
    if (starts.size() >= count || !std::isfinite(item.first)) break;
    const Vec3& p = points[item.second];
    const bool near = std::any_of(starts.begin(), starts.end(), [&](const FitState& s) {
      return (s.a - p).norm() < 0.1 * distance;
    });
    if (!near) starts.push_back({p, 0});
  }
  return starts;
}

}  // namespace vir::ranging
