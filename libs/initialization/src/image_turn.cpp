#include "vir/initialization/image_turn.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"
#include "vir/core/time_bounds.h"

namespace vir::initialization {
namespace {

constexpr std::size_t kFewestMatches = 12;
constexpr int kIterations = 6;

struct Pair {
  Vec3 a, b;
};

std::vector<Pair> pairsOf(const std::vector<AlignmentSight>& first,
                          const std::vector<AlignmentSight>& second) {
  std::vector<Pair> out;
  out.reserve(second.size());
  std::size_t j = 0;
  for (const AlignmentSight& s : first) {
    while (j < second.size() && second[j].id < s.id) ++j;
    if (j == second.size()) break;
    if (second[j].id == s.id) out.push_back({s.bearing, second[j].bearing});
  }
  return out;
}

/// The rotation alone that most pairs agree with: a = R b.
Mat3 rotationOnly(const std::vector<Pair>& pairs, double pixel) {
  Mat3 R = Mat3::Identity();
  double scale = 20 * pixel;
  for (int i = 0; i < kIterations; ++i) {
    Mat3 M = Mat3::Zero();
    for (const Pair& p : pairs) {
      const double ratio = i == 0 ? 0 : (p.a - R * p.b).norm() / scale;
      M += p.b * p.a.transpose() / (1 + ratio * ratio);
    }
    const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 S = Mat3::Identity();
    S(2, 2) = (svd.matrixV() * svd.matrixU().transpose()).determinant();
    R = svd.matrixV() * S * svd.matrixU().transpose();
    scale = std::max(pixel, 0.6 * scale);
  }
  return R;
}

/// Direction most nearly orthogonal to all normals of epipolar planes.
Vec3 directionFor(const std::vector<Pair>& pairs, const Mat3& R) {
  Mat3 M = Mat3::Zero();
  for (const Pair& p : pairs) {
    const Vec3 n = p.a.cross(R * p.b);
    M += n * n.transpose() / (n.norm() + 1e-4);
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(M).eigenvectors().col(0);
}

using Mat5 = Eigen::Matrix<double, 5, 5>;
using Vec5 = Eigen::Matrix<double, 5, 1>;

/// Normal equations of rotation (on the right of R) and direction, in units of pixels.
struct Epipolar {
  Mat5 H = Mat5::Zero();
  Vec5 g = Vec5::Zero();
  double squared_px = 0;  ///< weighted
  double weight = 0;
  Eigen::Matrix<double, 3, 2> basis;

  Epipolar(const std::vector<Pair>& pairs, const Mat3& R, const Vec3& t, double pixel) {
    basis.col(0) = t.unitOrthogonal();
    basis.col(1) = t.cross(basis.col(0));
    for (const Pair& p : pairs) {
      const Vec3 Rb = R * p.b;
      const Vec3 n = p.a.cross(Rb);
      const double ta = t.dot(p.a), tb = t.dot(Rb);
      // What a pixel of noise in both bearings makes of t.n. It depends on rotation and direction
      // itself: without that in the derivative, noise would pull both to where the lines are short.
      const double s2 = std::max(2 - ta * ta - tb * tb, 1e-4);
      const double scale = 1 / (pixel * std::sqrt(s2));
      const double r = scale * t.dot(n);
      const Eigen::RowVector3d by_turn = -t.transpose() * R * hat(p.b);  // of t.Rb
      Vec5 J;
      J.head<3>() = scale * (t.cross(p.a).transpose() * (-R * hat(p.b))).transpose() +
                    (r * tb / s2) * by_turn.transpose();
      J.tail<2>() = basis.transpose() * (scale * n + (r / s2) * (ta * p.a + tb * Rb));
      const double w = 1 / (1 + r * r);
      H += w * J * J.transpose();
      g += w * r * J;
      squared_px += w * r * r;
      weight += w;
    }
  }
  /// Of the rotation, whatever the direction; a direction that nothing shows is held.
  Mat3 rotationInformation() const {
    const Eigen::Matrix2d D =
        H.bottomRightCorner<2, 2>() + (1e-6 * H.trace() + 1e-9) * Eigen::Matrix2d::Identity();
    return H.topLeftCorner<3, 3>() -
           H.topRightCorner<3, 2>() * D.inverse() * H.bottomLeftCorner<2, 3>();
  }
};

}  // namespace

std::optional<ImageTurn> turnBetween(TimeNs t0, const std::vector<AlignmentSight>& first, TimeNs t1,
                                     const std::vector<AlignmentSight>& second, double focal_px) {
  const std::vector<Pair> pairs = pairsOf(first, second);
  if (pairs.size() < kFewestMatches || t1 <= t0) return std::nullopt;
  const double pixel = 1 / focal_px;
  Mat3 R = rotationOnly(pairs, pixel);
  Vec3 t = directionFor(pairs, R);
  for (int i = 0; i < kIterations; ++i) {
    const Epipolar e(pairs, R, t, pixel);
    const Mat5 damped = e.H + (1e-6 * e.H.trace() + 1e-9) * Mat5::Identity();
    const Vec5 step = damped.ldlt().solve(-e.g);
    if (!step.allFinite() || step.head<3>().norm() > 0.5) return std::nullopt;
    R = R * expSO3(step.head<3>());
    const Vec2 along = step.tail<2>();
    t = (t + e.basis * (along.norm() > 0.5 ? Vec2(0.5 * along.normalized()) : along)).normalized();
  }
  const Epipolar e(pairs, R, t, pixel);
  if (e.weight < 0.5 * static_cast<double>(pairs.size())) return std::nullopt;
  const double dt = toSeconds(timeBetween(t0, t1));
  ImageTurn out;
  out.t0 = t0;
  out.t1 = t1;
  out.rate_C = logSO3(R) / dt;
  out.information = e.rotationInformation() * dt * dt;
  if (!out.rate_C.allFinite() || !out.information.allFinite()) return std::nullopt;
  return out;
}

}  // namespace vir::initialization
