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
/// Nothing farther off than 0.1 rad is looked at.
constexpr double kNearCos = 0.995;

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

namespace {

/// Points of one side with known distances, looked for among those of the other.
struct Direction {
  const std::vector<LevelPoint>& from;
  const std::vector<LevelPoint>& to;
  bool forward;  ///< from the older into the newer
};

struct Pair {
  std::size_t from = 0, to = 0;
};

class Guide {
 public:
  Guide(const Pose& T, const VerifyOptions& o)
      : R_(T.R()),
        t_(T.p),
        sigma_rad_(o.sigma_px / o.focal_px),
        most_bits_(o.max_distance_bits + kMoreBits) {}

  /// Each `to` goes to the most alike `from`. Counts the points that must be in view.
  std::vector<Pair> match(const Direction& d, int* in_view) const {
    std::vector<int> best_of(d.to.size(), most_bits_ + 1);
    std::vector<std::size_t> owner(d.to.size(), 0);
    if (d.to.empty()) return {};
    const View view(d.to);
    for (std::size_t j = 0; j < d.from.size(); ++j) {
      if (!d.from[j].known()) continue;
      const Vec3 x = directionTo(d.from[j], d.to.front().eye, d.forward);
      if (!view.holds(x)) continue;
      ++*in_view;
      const Pair p = mostAlike(d, j, x);
      const int bits = p.to < d.to.size() ? difference(d, p) : most_bits_ + 1;
      if (p.to >= d.to.size() || bits >= best_of[p.to]) continue;
      best_of[p.to] = bits;
      owner[p.to] = j;
    }
    std::vector<Pair> out;
    for (std::size_t i = 0; i < d.to.size(); ++i) {
      if (best_of[i] <= most_bits_) out.push_back({owner[i], i});
    }
    return out;
  }

 private:
  static int difference(const Direction& d, const Pair& p) {
    return hammingDistance(d.from[p.from].point->descriptor, d.to[p.to].point->descriptor);
  }
  Vec3 directionTo(const LevelPoint& p, const Vec3& eye, bool forward) const {
    const Vec3 y = forward ? Vec3(R_.transpose() * (p.ray + p.rho * (p.eye - t_)) - p.rho * eye)
                           : Vec3(R_ * (p.ray + p.rho * p.eye) + p.rho * (t_ - eye));
    return y.normalized();
  }
  /// `to` is beyond the end if nothing is.
  Pair mostAlike(const Direction& d, std::size_t j, const Vec3& x) const {
    Pair out{j, d.to.size()};
    int best = most_bits_ + 1;
    for (std::size_t i = 0; i < d.to.size(); ++i) {
      if (x.dot(d.to[i].ray) < kNearCos) continue;
      const SightFit fit = fitSight({&d.from[j], &d.to[i], d.forward}, R_, t_, sigma_rad_, false);
      if (!fit.usable || fit.chi2 > kSearch * kSearch) continue;
      const int bits = difference(d, {j, i});
      if (bits >= best) continue;
      best = bits;
      out.to = i;
    }
    return out;
  }

  Mat3 R_;
  Vec3 t_;
  double sigma_rad_;
  int most_bits_;
};

}  // namespace

GuidedMatches matchGuided(const LevelPlaces& places, const Pose& T, const VerifyOptions& o) {
  const Guide guide(T, o);
  GuidedMatches out;
  int of_neighbours = 0;
  for (std::size_t f = 0; f < places.older.size(); ++f) {
    int* const in_view = f == 0 ? &out.in_view : &of_neighbours;
    const std::vector<LevelPoint>& older = places.older[f];
    std::vector<bool> done(older.size(), false);
    for (const Pair& p : guide.match({older, places.newer, true}, in_view)) {
      out.matches.push_back({p.to, f, p.from});
      done[p.from] = true;
    }
    for (const Pair& p : guide.match({places.newer, older, false}, in_view)) {
      // What both sides know of a match is used anyway.
      if (done[p.to] && older[p.to].known()) continue;
      out.matches.push_back({p.from, f, p.to});
    }
  }
  return out;
}

}  // namespace vir::places
