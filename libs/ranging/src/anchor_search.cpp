#include "anchor_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/ranging/range_correlation.h"

namespace vir::ranging {
namespace {

constexpr std::size_t kCoarse = 100, kProbe = 300, kStarts = 8;
constexpr int kMostSteps = 200;
/// Twice the cost between two optima below which they are one.
constexpr double kSeparate = 4;
/// An optimum so much worse on the few ranges looked at first is not followed up.
constexpr double kHopeless = 30;

/// Covariance of position and bias, the path's scale being as uncertain as it is.
Mat4 covarianceOf(const Mat5& information) {
  const Eigen::SelfAdjointEigenSolver<Mat5> eigen(information);
  const Vec5 inverse = eigen.eigenvalues().cwiseMax(1e-10).cwiseInverse();
  const Mat5 all = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
  return all.topLeftCorner<4, 4>();
}

}  // namespace

AnchorSearch::AnchorSearch(const FitData& data, const AnchorInitOptions& options,
                           const std::optional<AnchorPrior>& prior)
    : data_(data),
      options_(options),
      prior_(prior),
      shape_(pathShape(data.p)),
      coarse_data_(data.thinned(kCoarse)),
      probe_data_(data.thinned(kProbe)),
      full_(&data_, &options_, prior),
      coarse_(&coarse_data_, &options_, prior),
      probe_(&probe_data_, &options_, prior) {
  coarse_.setTolerance(1e-3);
  probe_.setTolerance(1e-4);
}

std::vector<Optimum> AnchorSearch::refined(const std::vector<FitState>& starts, const RangeFit& fit,
                                           int iterations) const {
  std::vector<Optimum> optima;
  for (const FitState& start : starts) {
    Optimum o;
    o.x = fit.minimise(start, iterations, nullptr, &o.cost);
    if (o.x.a.allFinite() && std::isfinite(o.cost)) optima.push_back(o);
  }
  std::stable_sort(optima.begin(), optima.end(),
                   [](const Optimum& a, const Optimum& b) { return a.cost < b.cost; });
  std::vector<Optimum> distinct;
  for (const Optimum& o : optima) {
    const double distance = (o.x.a - shape_.centre).norm();
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Optimum& d) {
      return (d.x.a - o.x.a).norm() < 1e-3 + 0.01 * distance;
    });
    if (!known) distinct.push_back(o);
  }
  return distinct;
}

/// The best optima and their images at the path's plane and at its line.
std::vector<FitState> AnchorSearch::withMirrors(const std::vector<Optimum>& optima) const {
  std::vector<FitState> starts;
  for (std::size_t i = 0; i < optima.size() && i < 3; ++i) {
    FitState x = optima[i].x;
    starts.push_back(x);
    const Vec3 local = shape_.axes.transpose() * (x.a - shape_.centre);
    // On the plane the mirror image is the same point, and a saddle: leave it to both sides.
    const double lift = std::max(std::abs(local[2]), 0.05 * local.norm());
    starts.push_back({shape_.centre + shape_.axes * Vec3(local[0], local[1], -local[2]), x.b, x.s});
    starts.push_back({shape_.centre + shape_.axes * Vec3(local[0], local[1], lift), x.b, x.s});
    starts.push_back({shape_.centre + shape_.axes * Vec3(local[0], local[1], -lift), x.b, x.s});
    if (i == 0) {
      starts.push_back(
          {shape_.centre + shape_.axes * Vec3(local[0], -local[1], local[2]), x.b, x.s});
    }
  }
  return starts;
}

std::vector<char> AnchorSearch::inliers(const FitState& x) const {
  std::vector<char> in;
  for (const double r : full_.residuals(x)) in.push_back(std::abs(r) < kInlierSigma * scale_);
  return in;
}

/// How large residuals are for what they claim, and what ranges that resemble one another are
/// worth.
void AnchorSearch::fixFactors(const FitState& best) {
  const std::vector<double> r = full_.residuals(best);
  if (options_.correlation) {
    std::vector<RangeResidual> series;
    for (std::size_t i = 0; i < r.size(); ++i) {
      if (std::abs(r[i]) < kInlierSigma * scale_) {
        series.push_back({static_cast<TimeNs>(i) * 1'000'000'000, r[i] / scale_, 1.0});
      }
    }
    worth_ = rangeCorrelation(series).correlation_factor;
  }
  full_.setFactors(scale_, worth_);
  const double share = static_cast<double>(probe_data_.size()) / static_cast<double>(data_.size());
  probe_.setFactors(scale_, worth_ * share);
}

std::vector<Optimum> AnchorSearch::run() {
  std::vector<FitState> starts = startPositions(coarse_, shape_, kStarts);
  if (prior_) starts.push_back({prior_->p_W, 0, 0});
  std::vector<Optimum> optima = refined(starts, coarse_, 12);
  if (optima.empty()) return optima;
  optima = refined(withMirrors(optima), coarse_, 12);
  // Residuals far beyond their sigma sit in the tails of the loss: take the scale from them and
  // look again.
  for (int k = 0; k < 2; ++k) {
    const double scale = robustScale(full_.residuals(optima.front().x));
    if (scale == scale_) break;
    scale_ = scale;
    coarse_.setFactors(scale_, 1);
    optima = refined(withMirrors(optima), coarse_, 12);
  }
  full_.setFactors(scale_, 1);
  fixFactors(full_.minimise(optima.front().x, 20));
  starts.clear();
  for (const Optimum& o : optima) {
    if (starts.size() < 4 && o.cost < optima.front().cost + kHopeless) starts.push_back(o.x);
  }
  optima = refined(starts, full_, 30);

  std::vector<Optimum> kept;
  for (const Optimum& o : optima) {
    if (2 * (o.cost - optima.front().cost) > options_.mirror_chi2) continue;
    bool own = true;
    for (Optimum& k : kept) {
      Optimum middle;
      if (separated(k, o, &middle)) continue;
      k = middle;
      own = false;
      break;
    }
    if (own) kept.push_back(o);
  }
  countOutliers(kept.front().x);
  return kept;
}

void AnchorSearch::countOutliers(const FitState& best) {
  const std::vector<double> r = full_.residuals(best);
  const std::size_t newest = r.size() - std::max<std::size_t>(1, r.size() / 5);
  int fit = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (r[i] >= kInlierSigma * scale_) ++too_long_;
    if (r[i] <= -kInlierSigma * scale_) ++too_short_;
    if (i >= newest && std::abs(r[i]) < kInlierSigma * scale_) ++fit;
  }
  newest_share_ = fit / static_cast<double>(r.size() - newest);
}

/// Is there a rise of the cost between two optima? If not, `middle` stands for both.
bool AnchorSearch::separated(const Optimum& a, const Optimum& b, Optimum* middle) const {
  const Vec3 between = b.x.a - a.x.a;
  const double distance = between.norm();
  middle->x = a.x;
  middle->cost = std::min(a.cost, b.cost);
  middle->merged = true;
  if (distance < 1e-6) return false;
  const Vec3 direction = between / distance;
  double at_a = 0, at_b = 0, cost = 0;
  probe_.minimise(a.x, 5, &direction, &at_a);
  probe_.minimise(b.x, 5, &direction, &at_b);
  const FitState x =
      probe_.minimise({0.5 * (a.x.a + b.x.a), 0.5 * (a.x.b + b.x.b), a.x.s}, 12, &direction, &cost);
  if (2 * (cost - std::max(at_a, at_b)) > kSeparate) return true;
  middle->x = full_.minimise(x, 8, &direction);
  return false;
}

bool AnchorSearch::ringFits(const Optimum& best) const {
  const Vec3 axis = shape_.axes.col(0);
  const Vec3 foot = shape_.centre + axis * axis.dot(best.x.a - shape_.centre);
  const Vec3 radial = best.x.a - foot;
  if (radial.norm() < 1e-3) return false;
  const Vec3 side = axis.cross(radial);
  double least = 0;
  probe_.minimise(best.x, 8, nullptr, &least);
  for (int k = 1; k < 8; ++k) {
    const double angle = k * kPi / 4;
    const Vec3 tangent = (std::cos(angle) * side - std::sin(angle) * radial).normalized();
    double cost = 0;
    const Vec3 p = foot + std::cos(angle) * radial + std::sin(angle) * side;
    probe_.minimise({p, best.x.b, best.x.s}, 10, &tangent, &cost);
    if (2 * (cost - least) > options_.mirror_chi2) return false;
  }
  return true;
}

/// Distance along `direction` at which twice the cost has risen by 1, everything else refitted: a
/// standard deviation that also holds where the ranges depend on the coordinate by its square only.
double AnchorSearch::profileSigma(const FitState& x, double cost, const Vec3& direction,
                                  double guess) const {
  const double farthest = 3 * (x.a - shape_.centre).norm() + 1;
  double widest = 0;
  for (const double sign : {-1.0, 1.0}) {
    const auto rise = [&](double step) {
      double there = 0;
      probe_.minimise({x.a + sign * step * direction, x.b, x.s}, 6, &direction, &there);
      return 2 * (there - cost);
    };
    double inside = 0, outside = std::min(guess, farthest);
    for (int k = 0; k < kMostSteps && outside < farthest && rise(outside) < 1; ++k) {
      inside = outside;
      outside *= 1.7;
    }
    for (int k = 0; k < 6; ++k) {
      const double middle = 0.5 * (inside + outside);
      (rise(middle) < 1 ? inside : outside) = middle;
    }
    widest = std::max(widest, std::min(0.5 * (inside + outside), farthest));
  }
  return widest;
}

void AnchorSearch::widenAlongWeakAxes(const Optimum& optimum, const FitState& x,
                                      Mat4* covariance) const {
  const double distance = (x.a - shape_.centre).norm();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance->topLeftCorner<3, 3>());
  double cost = 0;
  bool known = false;
  for (const int axis : {2, 1}) {
    const double sigma = std::sqrt(std::max(eigen.eigenvalues()[axis], 1e-12));
    if (sigma < 0.05 * distance && !(optimum.merged && axis == 2)) continue;
    const Vec3 v = eigen.eigenvectors().col(axis);
    if (!known) probe_.minimise(x, 6, optimum.merged ? &v : nullptr, &cost);
    known = true;
    const double least = optimum.merged ? std::min(cost, probe_.cost(optimum.x)) : cost;
    const double profile = profileSigma(x, least, v, std::min(sigma, 0.1 * distance + 0.01));
    Mat4 S = Mat4::Identity();
    S.topLeftCorner<3, 3>() += (profile / sigma - 1) * v * v.transpose();
    *covariance = S * *covariance * S.transpose();
  }
}

/// Drift is the same for neighbouring ranges, so it does not average out as their noise does: the
/// anchor moves along with the path where its ranges were taken. Variance per axis.
double AnchorSearch::commonDrift(const std::vector<char>& in) const {
  double drift = 0, weights = 0;
  for (std::size_t i = 0; i < data_.size(); ++i) {
    if (!in[i]) continue;
    const double weight = 1 / (data_.sigma[i] * data_.sigma[i]);
    drift += weight * data_.drift[i];
    weights += weight;
  }
  return weights > 0 ? (drift / weights) * (drift / weights) : 0;
}

AnchorSolution AnchorSearch::solution(const Optimum& optimum) {
  const std::vector<char> in = inliers(optimum.x);
  full_.setInliers(&in);
  // A point between two mirror images is held there: least squares would fall to either side.
  Vec3 held = Vec3::Zero();
  if (optimum.merged) {
    const Mat4 C = covarianceOf(full_.information(optimum.x));
    held = Eigen::SelfAdjointEigenSolver<Mat3>(C.topLeftCorner<3, 3>()).eigenvectors().col(2);
  }
  const FitState x = full_.minimise(optimum.x, 20, optimum.merged ? &held : nullptr);
  AnchorSolution solution;
  solution.covariance = covarianceOf(full_.information(x));
  full_.setInliers(nullptr);
  widenAlongWeakAxes(optimum, x, &solution.covariance);
  solution.covariance.topLeftCorner<3, 3>() += commonDrift(in) * Mat3::Identity();
  solution.covariance = (0.5 * (solution.covariance + solution.covariance.transpose())).eval();
  solution.p_W = x.a;
  solution.bias_m = x.b;
  solution.cost = optimum.cost;
  return solution;
}

}  // namespace vir::ranging
