#include "loop_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "vir/core/random.h"

namespace vir::places {
namespace {

/// A sight says where a point is only if the doubt about its distance moves it less than this
/// [sigmas of a ray].
constexpr double kLongestDoubt = 8;
/// Only distances known better than this (relative) make a first guess.
constexpr double kGuessDistance = 0.3;
/// A search ends when a better pose would have been met with this probability.
constexpr double kMissed = 1e-3;
/// A first guess takes the verticals for known; roll and pitch of a run that has just begun are off
/// by so much of what they may be, all over the image.
constexpr double kTiltShare = 0.4;
/// Guesses that hardly explain more than two points are none.
constexpr int kFewestExplained = 4;

Vec3 placeOf(const LevelPoint& p) { return p.eye + p.ray / p.rho; }

bool guessable(const LevelPoint& p) { return p.known() && p.sigma < kGuessDistance * p.rho; }

/// A vector across a unit vector.
Vec3 anyAcross(const Vec3& f) {
  return f.cross(std::abs(f.z()) < 0.9 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitX())).normalized();
}

class Search {
 public:
  Search(const LevelPlaces& places, const std::vector<PointMatch>& matches,
         const VerifyOptions& options)
      : options_(options),
        sigma_rad_(searchSigma(options)),
        random_(static_cast<std::uint64_t>(options.seed), 620) {
    for (const PointMatch& m : matches) {
      sights_.push_back(sightsOf(places, m));
      for (const Sight& s : sights_.back()) {
        if (guessable(*s.from)) (s.forward ? forward_ : backward_).push_back(s);
      }
    }
  }

  std::optional<Pose> run() {
    for (int k = 0; k < options_.max_iterations && k < needed_; ++k) guess(k);
    if (most_ < kFewestExplained) return std::nullopt;
    return best_;
  }

 private:
  void guess(int k);
  void rate(const Pose& T);

  const VerifyOptions& options_;
  double sigma_rad_;
  Random random_;
  std::vector<std::vector<Sight>> sights_;
  std::vector<Sight> forward_, backward_;
  std::optional<Pose> best_;
  double least_ = 0;
  int most_ = 0;
  double needed_ = 1e9;
};

void Search::guess(int k) {
  // Both directions in turn, as far as there are points of either.
  const bool both = forward_.size() > 1 && backward_.size() > 1;
  const bool ahead = both ? k % 2 == 0 : forward_.size() > 1;
  const std::vector<Sight>& from = ahead ? forward_ : backward_;
  if (from.size() < 2) return;
  const std::size_t i = random_.below(from.size());
  std::size_t j = random_.below(from.size() - 1);
  j += j >= i;
  const LevelPoint &p1 = *from[i].from, &p2 = *from[j].from;
  const LevelPoint &q1 = *from[i].to, &q2 = *from[j].to;
  const Vec3 x1 = placeOf(p1), x2 = placeOf(p2);
  for (const TwoPointPose& s : solveTwoPoints(x1 - x2, q1.ray, q2.ray, q1.eye - q2.eye)) {
    // Rz x + t = eye + a ray, from the frame of the distances into that of the rays.
    const Mat3 R = rotZ(s.yaw);
    const Pose T(Quat(R), q1.eye + s.a * q1.ray - R * x1);
    rate(ahead ? T.inverse() : T);
  }
}

void Search::rate(const Pose& T) {
  const Mat3 R = T.R();
  double cost = 0;
  int good = 0;
  for (const std::vector<Sight>& of_match : sights_) {
    double least = kInlierChi2;
    for (const Sight& s : of_match) {
      const SightFit fit = fitSight(s, R, T.p, sigma_rad_, false);
      if (fit.usable) least = std::min(least, fit.chi2);
    }
    good += least < kInlierChi2;
    cost += least;
    if (best_ && cost >= least_) return;
  }
  best_ = T;
  least_ = cost;
  most_ = good;
  const double share = static_cast<double>(good) / static_cast<double>(sights_.size());
  // Noise spoils some guesses of two right matches: half of them are counted as useful.
  const double useful = 0.5 * share * share;
  needed_ = useful < 1 ? std::log(kMissed) / std::log1p(-useful) + 1 : 1;
}

}  // namespace

SightFit fitSight(const Sight& s, const Mat3& R, const Vec3& t, double sigma_rad,
                  bool with_jacobian) {
  const LevelPoint &a = *s.from, &b = *s.to;
  SightFit out;
  // y: direction of the point from b's eye, times rho. slide: how it moves with rho.
  Vec3 y, slide, arm;
  if (s.forward) {
    arm = R.transpose() * (a.ray + a.rho * (a.eye - t));
    slide = R.transpose() * (a.eye - t) - b.eye;
    y = arm - a.rho * b.eye;
  } else {
    arm = a.ray + a.rho * a.eye;
    slide = R * a.eye + t - b.eye;
    y = R * arm + a.rho * (t - b.eye);
  }
  const double length = y.norm();
  if (!(length > 1e-6)) return out;
  const Vec3 x = y / length;
  if (x.dot(b.ray) < 0.7) return out;
  // Axes across the ray: along the slide and across it.
  const Vec3 doubt = (slide - x * x.dot(slide)) * (a.sigma / length);
  const double doubt_rad = doubt.norm();
  if (!(doubt_rad < kLongestDoubt * sigma_rad)) return out;
  Vec3 u = doubt - b.ray * b.ray.dot(doubt);
  u = u.norm() > 1e-9 ? Vec3(u.normalized()) : anyAcross(b.ray);
  const Vec3 v = b.ray.cross(u);
  const double weight_u = 1 / std::hypot(sigma_rad, doubt_rad), weight_v = 1 / sigma_rad;
  out.usable = true;
  out.r = Vec2(weight_u * u.dot(x), weight_v * v.dot(x));
  out.chi2 = out.r.squaredNorm();
  if (!with_jacobian) return out;
  Mat23 P;
  P.row(0) = weight_u / length * (u - x * x.dot(u)).transpose();
  P.row(1) = weight_v / length * (v - x * x.dot(v)).transpose();
  if (s.forward) {
    out.J.leftCols<3>() = -a.rho * P * R.transpose();
    out.J.rightCols<3>() = P * hat(arm);
  } else {
    out.J.leftCols<3>() = a.rho * P;
    out.J.rightCols<3>() = -P * R * hat(arm);
  }
  return out;
}

double searchSigma(const VerifyOptions& options) {
  return std::hypot(options.sigma_px / options.focal_px, kTiltShare * options.gravity_sigma_rad);
}

std::vector<Sight> sightsOf(const LevelPlaces& places, const PointMatch& m) {
  const LevelPoint& older = places.older[m.frame][m.older];
  const LevelPoint& newer = places.newer[m.newer];
  std::vector<Sight> out;
  if (older.known()) out.push_back({&older, &newer, true});
  if (newer.known()) out.push_back({&newer, &older, false});
  return out;
}

std::vector<PointMatch> explained(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                                  const Pose& T, double sigma_rad) {
  const Mat3 R = T.R();
  std::vector<PointMatch> out;
  for (const PointMatch& m : matches) {
    const std::vector<Sight> sights = sightsOf(places, m);
    const bool fits = std::any_of(sights.begin(), sights.end(), [&](const Sight& s) {
      const SightFit fit = fitSight(s, R, T.p, sigma_rad, false);
      return fit.usable && fit.chi2 < kInlierChi2;
    });
    if (fits) out.push_back(m);
  }
  return out;
}

std::vector<TwoPointPose> solveTwoPoints(const Vec3& d, const Vec3& f1, const Vec3& f2,
                                         const Vec3& o) {
  // The vertical gives one distance by the other; the one whose ray is steeper is eliminated.
  const bool first = std::abs(f1.z()) >= std::abs(f2.z());
  const Vec3& gone = first ? f1 : f2;
  const Vec3& kept = first ? f2 : f1;
  const double sign = first ? 1 : -1;
  if (std::abs(gone.z()) < 1e-4) return {};
  // gone's distance = sign (d - o).z / gone.z + kept.z / gone.z * x.
  const double at = sign * (d.z() - o.z()) / gone.z(), slope = kept.z() / gone.z();
  const Vec2 a = sign * at * gone.head<2>() + o.head<2>();
  const Vec2 b = sign * (slope * gone.head<2>() - kept.head<2>());
  // |a + x b| = |d| across the vertical.
  const double bb = b.squaredNorm(), ab = a.dot(b);
  const double rest = a.squaredNorm() - d.head<2>().squaredNorm();
  const double root = ab * ab - bb * rest;
  if (!(bb > 1e-12) || !(root >= 0)) return {};
  std::vector<TwoPointPose> out;
  for (const double side : {-1.0, 1.0}) {
    const double x = (-ab + side * std::sqrt(root)) / bb, g = at + slope * x;
    if (!(x > 0 && g > 0)) continue;
    const Vec2 v = a + x * b;
    const double yaw = std::atan2(v.y(), v.x()) - std::atan2(d.y(), d.x());
    out.push_back(first ? TwoPointPose{yaw, g, x} : TwoPointPose{yaw, x, g});
  }
  return out;
}

std::optional<Pose> searchPose(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                               const VerifyOptions& options) {
  return matches.empty() ? std::nullopt : Search(places, matches, options).run();
}

}  // namespace vir::places
