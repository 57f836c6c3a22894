#include "vir/check/range_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "vir/core/order_statistics.h"
#include "vir/geometry/interpolation.h"
#include "vir/ranging/range_correlation.h"

namespace vir::check {
namespace {

using Vec5 = Eigen::Matrix<double, 5, 1>;
using Mat5 = Eigen::Matrix<double, 5, 5>;

constexpr TimeNs kMaxGap = 200'000'000, kMinStep = 10'000'000;
constexpr std::size_t kMostPoses = 200'000;
constexpr std::size_t kFewest = 30, kForStarts = 150, kForFit = 600;
constexpr TimeNs kHalfStep = 10'000'000;  // for the antenna's velocity
constexpr double kLeastNoise = 0.01;      // [m]
constexpr double kFarOffset = 5;          // [s]

/// Anchor x y z, bias, offset: standard deviations of what is thought of them beforehand.
const Vec5 kPrior = (Vec5() << 100, 100, 100, 10, 1).finished();

struct Look {
  const Range* range = nullptr;
  double range_m = 0;
};

/// Every so many of them that about `most` are left.
std::vector<Look> thinned(const std::vector<Look>& all, std::size_t most) {
  std::vector<Look> out;
  const std::size_t stride = (all.size() + most - 1) / most;
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(stride, 1)) {
    out.push_back(all[i]);
  }
  return out;
}

/// The antenna at the times of some ranges, moved by an offset.
struct Antennas {
  std::vector<Vec3> points, velocities;
  std::vector<double> ranges;
  std::vector<TimeNs> times;
};

Antennas antennasAt(const KnownPath& path, const std::vector<Look>& looks, double offset_s) {
  Antennas out;
  for (const Look& l : looks) {
    const TimeNs t = l.range->t + fromSeconds(offset_s);
    const auto before = path.at(t - kHalfStep, l.range->p_B_U);
    const auto after = path.at(t + kHalfStep, l.range->p_B_U);
    if (!before || !after) continue;
    out.points.push_back((*before + *after) / 2);
    out.velocities.push_back((*after - *before) / toSeconds(2 * kHalfStep));
    out.ranges.push_back(l.range_m);
    out.times.push_back(l.range->t);
  }
  return out;
}

double residual(const Antennas& a, std::size_t i, const Vec5& x) {
  return a.ranges[i] - (x.head<3>() - a.points[i]).norm() - x[3];
}

double spreadOf(const Antennas& a, const Vec5& x) {
  std::vector<double> rest;
  for (std::size_t i = 0; i < a.points.size(); ++i) rest.push_back(std::abs(residual(a, i, x)));
  return medianInPlace(&rest) / 0.6745;
}

/// Normal equations at x with Cauchy's loss of `scale` and the priors about `about`, in units of
/// scale^2. Returns the mean cost.
double normalEquations(const Antennas& a, const Vec5& x, const Vec5& about, double scale, Mat5* H,
                       Vec5* g) {
  const double scale2 = scale * scale;
  H->setZero();
  g->setZero();
  double cost = 0;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const Vec3 d = x.head<3>() - a.points[i];
    const double distance = std::max(d.norm(), 1e-6);
    const double r = a.ranges[i] - distance - x[3];
    const double weight = 1 / (1 + r * r / scale2);
    Vec5 J;
    J << d / distance, 1, -d.dot(a.velocities[i]) / distance;
    *H += weight * J * J.transpose();
    *g += weight * r * J;
    cost += std::log1p(r * r / scale2);
  }
  const Vec5 information = scale2 * kPrior.cwiseAbs2().cwiseInverse();
  *H += Mat5(information.asDiagonal());
  *g -= information.cwiseProduct(x - about);
  cost += (information / scale2).dot((x - about).cwiseAbs2());
  return a.points.empty() ? 1e300 : cost / static_cast<double>(a.points.size());
}

struct Problem {
  const KnownPath& path;
  std::vector<Look> looks;
  Vec5 about = Vec5::Zero();  ///< what the priors lie about
  bool anchor_free = true, offset_free = true;
};

/// From one start; the scale of the loss follows the spread. Returns the final cost at 0.1 m.
double descend(const Problem& problem, int iterations, Antennas antennas, Vec5* x) {
  Mat5 H;
  Vec5 g;
  double damping = 1e-3;
  for (int i = 0; i < iterations; ++i) {
    const double scale = 2 * std::max(spreadOf(antennas, *x), kLeastNoise);
    const double cost = normalEquations(antennas, *x, problem.about, scale, &H, &g);
    if (!problem.anchor_free) H.topLeftCorner<3, 3>().diagonal().array() += 1e12;
    if (!problem.offset_free) H(4, 4) += 1e12;
    Vec5 step =
        (H + damping * Mat5(H.diagonal().asDiagonal()) + 1e-9 * Mat5::Identity()).ldlt().solve(g);
    if (!problem.anchor_free) step.head<3>().setZero();
    if (!problem.offset_free) step[4] = 0;
    const Vec5 next = *x + step;
    if (!next.allFinite() || std::abs(next[4]) > kFarOffset) {
      damping *= 10;
    } else {
      Antennas moved =
          problem.offset_free ? antennasAt(problem.path, problem.looks, next[4]) : Antennas();
      const Antennas& there = problem.offset_free ? moved : antennas;
      Mat5 ignored_H;
      Vec5 ignored_g;
      const bool enough = there.points.size() * 5 >= problem.looks.size() * 3;
      if (enough &&
          normalEquations(there, next, problem.about, scale, &ignored_H, &ignored_g) < cost) {
        *x = next;
        if (problem.offset_free) antennas = std::move(moved);
        damping = std::max(damping / 5, 1e-9);
        if (step.norm() < 1e-7) break;
      } else {
        damping *= 10;
      }
    }
    if (damping > 1e6) break;
  }
  return normalEquations(antennas, *x, problem.about, 0.1, &H, &g);
}

/// Along the axes, and into the corners.
std::vector<Vec3> directions() {
  std::vector<Vec3> out;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int along = (x != 0) + (y != 0) + (z != 0);
        if (along == 1 || along == 3) out.push_back(Vec3(x, y, z).normalized());
      }
    }
  }
  return out;
}

/// Rough solutions, the best first.
std::vector<std::pair<double, Vec5>> starts(Problem problem) {
  std::vector<std::pair<double, Vec5>> out;
  const std::vector<Look> all = problem.looks;
  problem.looks = thinned(all, kForStarts);
  problem.offset_free = false;
  for (const double offset : {0.0, 0.25, -0.25, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0}) {
    const Antennas antennas = antennasAt(problem.path, problem.looks, offset);
    if (antennas.points.size() < 20) continue;
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : antennas.points) middle += p / double(antennas.points.size());
    const double typical = median(antennas.ranges);
    std::vector<Vec3> from;
    if (problem.anchor_free) {
      for (const Vec3& d : directions()) from.push_back(middle + typical * d);
    } else {
      from.push_back(problem.about.head<3>());
    }
    for (const Vec3& p : from) {
      Vec5 x = problem.about;
      x.head<3>() = p;
      x[4] = offset;
      if (!x.allFinite()) continue;
      const double cost = descend(problem, 25, antennas, &x);
      if (x.allFinite() && std::isfinite(cost)) out.emplace_back(cost, x);
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return out;
}

/// Standard deviations of bias and offset at the solution.
void uncertainty(const Problem& problem, const Antennas& antennas, const Vec5& x, long used,
                 AnchorFit* fit) {
  std::vector<ranging::RangeResidual> rest;
  for (std::size_t i = 0; i < antennas.points.size(); ++i) {
    rest.push_back({antennas.times[i], residual(antennas, i, x), fit->noise_m});
  }
  const double likeness = ranging::rangeCorrelation(rest).correlation_factor;
  fit->independent = static_cast<double>(used) / likeness;
  // Only some of the ranges were looked at; the others say as much, as far as they are independent.
  const double share =
      static_cast<double>(antennas.points.size()) / std::max(fit->independent, double(kFewest));
  Mat5 H;
  Vec5 g;
  normalEquations(antennas, x, problem.about, 3 * fit->noise_m, &H, &g);
  if (!problem.anchor_free) H.topLeftCorner<3, 3>().diagonal().array() += 1e12;
  const Mat5 covariance = H.inverse() * fit->noise_m * fit->noise_m * share;
  fit->bias_sigma_m = std::sqrt(covariance(3, 3));
  fit->offset_sigma_s = std::sqrt(covariance(4, 4));
  fit->found = std::isfinite(fit->bias_sigma_m) && std::isfinite(fit->offset_sigma_s);
}

}  // namespace

void KnownPath::add(const StampedPose& pose) {
  if (poses_.size() >= kMostPoses || !pose.T_W_B.p.allFinite()) return;
  if (!poses_.empty() && pose.t < poses_.back().t + kMinStep) return;
  poses_.push_back(pose);
}

std::optional<Pose> KnownPath::poseAt(TimeNs t) const {
  const auto around = aroundOf(t);
  if (!around) return std::nullopt;
  return interpolate(around->a->T_W_B, around->b->T_W_B, around->share);
}

std::optional<Vec3> KnownPath::at(TimeNs t, const Vec3& p_B_U) const {
  const auto around = aroundOf(t);
  if (!around) return std::nullopt;
  const Pose &a = around->a->T_W_B, &b = around->b->T_W_B;
  if (p_B_U.isZero()) return a.p + around->share * (b.p - a.p);
  return interpolate(a, b, around->share) * p_B_U;
}

/// Empty outside of the path and in its gaps.
std::optional<KnownPath::Around> KnownPath::aroundOf(TimeNs t) const {
  const auto after = std::upper_bound(poses_.begin(), poses_.end(), t,
                                      [](TimeNs x, const StampedPose& p) { return x < p.t; });
  if (after == poses_.begin() || after == poses_.end()) return std::nullopt;
  const StampedPose &a = *(after - 1), &b = *after;
  if (b.t - a.t > kMaxGap) return std::nullopt;
  return Around{&a, &b, static_cast<double>(t - a.t) / static_cast<double>(b.t - a.t)};
}

AnchorFit fitAnchor(const KnownPath& path, const std::vector<Range>& ranges, double unit_m,
                    const std::optional<Vec3>& held) {
  AnchorFit fit;
  Problem problem{path, {}};
  std::vector<Look> all;
  Vec3 middle = Vec3::Zero();
  for (const Range& r : ranges) {
    const auto p = path.at(r.t, r.p_B_U);
    if (!p || !std::isfinite(r.range_m) || r.range_m <= 0) continue;
    all.push_back({&r, r.range_m * unit_m});
    middle += *p;
  }
  fit.used = static_cast<long>(all.size());
  if (all.size() < kFewest) return fit;
  problem.about.head<3>() = held ? *held : Vec3(middle / double(all.size()));
  problem.anchor_free = !held;
  problem.looks = thinned(all, kForFit);
  double best = 1e300;
  Vec5 x = Vec5::Zero();
  int tried = 0;
  for (const auto& [rough, start] : starts(problem)) {
    if (++tried > 3) break;
    Vec5 refined = start;
    const double cost = descend(problem, 60, antennasAt(path, problem.looks, start[4]), &refined);
    if (!refined.allFinite() || !(cost < best)) continue;
    best = cost;
    x = refined;
  }
  if (best == 1e300) return fit;
  const Antennas antennas = antennasAt(path, problem.looks, x[4]);
  fit.p_W = x.head<3>();
  fit.bias_m = x[3];
  fit.offset_s = x[4];
  fit.noise_m = std::max(spreadOf(antennas, x), kLeastNoise);
  fit.antennas_W = antennas.points;
  fit.ranges_m = antennas.ranges;
  fit.times = antennas.times;
  uncertainty(problem, antennas, x, fit.used, &fit);
  return fit;
}

}  // namespace vir::check
