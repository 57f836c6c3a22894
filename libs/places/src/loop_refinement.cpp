#include "loop_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vir/places/hamming.h"

namespace vir::places {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr int kSteps = 8;
/// A corner found again lies within this of where the pose says [sigmas of a ray].
constexpr double kSearch = 8;
/// Where the pose says what to expect, descriptors may differ by this many bits more.
constexpr int kMoreBits = 16;
/// The rim of the other view is not counted on [rad].
constexpr double kRim = 0.02;

struct Normal {
  Mat6 H = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  double chi2 = 0, weight = 0;
};

/// How much of itself a match adds: what several keyframes say of one corner is one word.
std::vector<double> shares(const std::vector<PointMatch>& matches, std::size_t newer) {
  std::vector<int> times(newer, 0);
  for (const PointMatch& m : matches) ++times[m.newer];
  std::vector<double> out;
  for (const PointMatch& m : matches) out.push_back(1.0 / times[m.newer]);
  return out;
}

/// The sight that says most, if any is usable.
SightFit bestFit(const LevelPlaces& places, const PointMatch& m, const Mat3& R, const Vec3& t,
                 double sigma_rad) {
  SightFit best;
  for (const Sight& s : sightsOf(places, m)) {
    const SightFit fit = fitSight(s, R, t, sigma_rad, true);
    if (fit.usable && (!best.usable || fit.chi2 < best.chi2)) best = fit;
  }
  return best;
}

Normal normalEquations(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                       const Pose& T, const VerifyOptions& o) {
  const Mat3 R = T.R();
  const std::vector<double> share = shares(matches, places.newer.size());
  Normal n;
  for (std::size_t k = 0; k < matches.size(); ++k) {
    const SightFit fit = bestFit(places, matches[k], R, T.p, o.sigma_px / o.focal_px);
    if (!fit.usable) continue;
    const double w = share[k] / (1 + fit.chi2 / kInlierChi2);
    n.H += w * fit.J.transpose() * fit.J;
    n.b += w * fit.J.transpose() * fit.r;
    n.chi2 += w * fit.chi2;
    n.weight += w;
  }
  // Both verticals are known; R = Rz(yaw) Exp(tilt), to first order.
  const Vec3 tilt = logSO3(rotZ(nearestYaw(R)).transpose() * R);
  const double held = 1 / (2 * o.gravity_sigma_rad * o.gravity_sigma_rad);
  for (int axis = 0; axis < 2; ++axis) {
    n.H(3 + axis, 3 + axis) += held;
    n.b(3 + axis) += held * tilt(axis);
  }
  return n;
}

/// The part of a cone or rectangle around the axis of sight that a keyframe's rays fill.
class View {
 public:
  explicit View(const std::vector<LevelPoint>& points) {
    Vec3 mean = Vec3::Zero();
    for (const LevelPoint& p : points) mean += p.ray;
    if (!(mean.norm() > 1e-6)) return;
    axis_ = mean.normalized();
    right_ = axis_.cross(std::abs(axis_.z()) < 0.9 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitX()))
                 .normalized();
    up_ = right_.cross(axis_);
    for (const LevelPoint& p : points) {
      const double along = p.ray.dot(axis_);
      if (along < 0.2) continue;
      const Vec2 at(p.ray.dot(right_) / along, p.ray.dot(up_) / along);
      low_ = low_.cwiseMin(at);
      high_ = high_.cwiseMax(at);
    }
  }
  bool holds(const Vec3& x) const {
    const double along = x.dot(axis_);
    if (along < 0.2) return false;
    const Vec2 at(x.dot(right_) / along, x.dot(up_) / along);
    return ((at - low_).array() > kRim).all() && ((high_ - at).array() > kRim).all();
  }

 private:
  Vec3 axis_ = Vec3::UnitX(), right_ = Vec3::UnitY(), up_ = Vec3::UnitZ();
  Vec2 low_ = Vec2::Constant(1e9), high_ = Vec2::Constant(-1e9);
};

}  // namespace

RefinedPose refinePose(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                       const Pose& start, const VerifyOptions& o) {
  RefinedPose out;
  out.T_older_newer = start;
  Pose& T = out.T_older_newer;
  Normal n;
  for (int step = 0; step < kSteps; ++step) {
    n = normalEquations(places, matches, T, o);
    const Vec6 change = -n.H.ldlt().solve(n.b);
    if (!change.allFinite()) return out;
    T.p += change.head<3>();
    T.q = (T.q * expQuat(change.tail<3>())).normalized();
    if (change.norm() < 1e-9) break;
  }
  n = normalEquations(places, matches, T, o);
  const Eigen::LDLT<Mat6> ldlt(n.H);
  if (!(ldlt.vectorD().minCoeff() > 0)) return out;
  const double excess = n.weight > 3 ? n.chi2 / (2 * n.weight - 6) : 1;
  out.covariance = std::max(1.0, excess) * ldlt.solve(Mat6::Identity());
  out.valid = out.covariance.allFinite();
  return out;
}

GuidedMatches matchGuided(const LevelPlaces& places, const Pose& T, const VerifyOptions& o) {
  const double sigma_rad = o.sigma_px / o.focal_px;
  const Mat3 R = T.R();
  const View view(places.newer);
  const double nearest_cos = std::cos(0.1);
  GuidedMatches out;
  for (std::size_t f = 0; f < places.older.size(); ++f) {
    std::vector<int> best_of(places.newer.size(), std::numeric_limits<int>::max());
    std::vector<std::size_t> owner(places.newer.size(), 0);
    for (std::size_t j = 0; j < places.older[f].size(); ++j) {
      const LevelPoint& p = places.older[f][j];
      if (!p.known()) continue;
      const Vec3 y = R.transpose() * (p.ray + p.rho * (p.eye - T.p));
      const Vec3 x = (y - p.rho * places.newer.front().eye).normalized();
      if (!view.holds(x)) continue;
      out.in_view += f == 0;
      int best = o.max_distance_bits + kMoreBits + 1;
      std::size_t at = 0;
      for (std::size_t i = 0; i < places.newer.size(); ++i) {
        if (x.dot(places.newer[i].ray) < nearest_cos) continue;
        const SightFit fit = fitSight({&p, &places.newer[i], true}, R, T.p, sigma_rad, false);
        if (!fit.usable || fit.chi2 > kSearch * kSearch) continue;
        const int d = hammingDistance(p.point->descriptor, places.newer[i].point->descriptor);
        if (d >= best) continue;
        best = d;
        at = i;
      }
      if (best > o.max_distance_bits + kMoreBits || best >= best_of[at]) continue;
      best_of[at] = best;
      owner[at] = j;
    }
    for (std::size_t i = 0; i < places.newer.size(); ++i) {
      if (best_of[i] == std::numeric_limits<int>::max()) continue;
      out.matches.push_back({i, f, owner[i]});
    }
  }
  return out;
}

}  // namespace vir::places
