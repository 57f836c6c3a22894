#include "range_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"

namespace vir::ranging {
namespace {

/// An anchor is somewhere within 100 km: keeps the equations solvable where ranges say nothing.
constexpr double kWeakest = 1e-10;
/// Below this distance the direction to the anchor is not defined.
constexpr double kZeroDistance = 1e-9;
/// Of a bias [m] and a scale that are not estimated.
constexpr double kNoBias = 1e-6, kNoScale = 1e-6;

}  // namespace

double robustScale(std::vector<double> r) {
  double scale = 1;
  for (int k = 0; k < 5; ++k) {
    const double middle = median(r);
    std::vector<double> size;
    for (const double v : r) size.push_back(std::abs(v - middle));
    scale = 1.4826 * median(size);
    const auto outside = std::remove_if(r.begin(), r.end(), [&](double v) {
      return std::abs(v - middle) > kInlierSigma * std::max(scale, 1.0);
    });
    if (outside == r.end()) break;
    r.erase(outside, r.end());
  }
  return scale > 1.2 ? scale : 1.0;
}

FitData FitData::thinned(std::size_t count) const {
  FitData out;
  const std::size_t n = size(), m = std::min(count, n);
  for (std::size_t k = 0; k < m; ++k) {
    const std::size_t i = m > 1 ? k * (n - 1) / (m - 1) : 0;
    out.p.push_back(p[i]);
    out.z.push_back(z[i]);
    out.sigma.push_back(sigma[i]);
    out.drift.push_back(drift[i]);
  }
  return out;
}

RangeFit::RangeFit(const FitData* data, const AnchorInitOptions* options,
                   const std::optional<AnchorPrior>& prior)
    : data_(data), options_(options) {
  if (!prior) return;
  prior_information_ = prior->covariance.inverse();
  prior_mean_ = prior->p_W;
}

double RangeFit::build(const FitState& x, Mat5* H, Vec5* g) const {
  double cost = 0;
  const double grown = std::exp(x.s) - 1;
  const Vec3 end = data_->size() ? data_->p.back() : Vec3::Zero();
  if (H) H->setZero(), g->setZero();
  const double weigh = 1 / worth_;
  for (std::size_t i = 0; i < data_->size(); ++i) {
    if (inliers_ && !(*inliers_)[i]) continue;
    const Vec3 way = data_->p[i] - end;
    const Vec3 v = x.a - data_->p[i] - grown * way;
    const double d = v.norm();
    const double inverse_sigma = 1 / (data_->sigma[i] * scale_);
    const double r = (data_->z[i] - d - x.b) * inverse_sigma;
    double loss = 0.5 * r * r, influence = 1;
    if (!inliers_) {
      const RobustRange::Value value = options_->robust.evaluate(r);
      loss = 0.5 * value.e * value.e;
      influence = value.influence();
    }
    cost += weigh * loss;
    if (!H) continue;
    Vec5 J = Vec5::Zero();
    if (d > kZeroDistance) {
      J.head<3>() = -inverse_sigma / d * v;
      J[4] = inverse_sigma / d * (1 + grown) * v.dot(way);
    }
    J[3] = -inverse_sigma;
    const double w = weigh * influence;
    H->noalias() += w * J * J.transpose();
    *g += w * r * J;
  }
  addPriors(x, &cost, H, g);
  return cost;
}

void RangeFit::addPriors(const FitState& x, double* cost, Mat5* H, Vec5* g) const {
  const double sigma_b = std::max(options_->bias_sigma_m, kNoBias);
  const double sigma_s = std::max(options_->scale_sigma, kNoScale);
  const Vec3 off = x.a - prior_mean_;
  const Vec3 pull = prior_information_ * off;
  const double pull_b = x.b / (sigma_b * sigma_b), pull_s = x.s / (sigma_s * sigma_s);
  *cost += 0.5 * (off.dot(pull) + x.b * pull_b + x.s * pull_s);
  if (!H) return;
  H->topLeftCorner<3, 3>() += prior_information_ + kWeakest * Mat3::Identity();
  (*H)(3, 3) += 1 / (sigma_b * sigma_b);
  (*H)(4, 4) += 1 / (sigma_s * sigma_s);
  g->head<3>() += pull;
  (*g)[3] += pull_b;
  (*g)[4] += pull_s;
}

double RangeFit::cost(const FitState& x) const { return build(x, nullptr, nullptr); }

Mat5 RangeFit::information(const FitState& x) const {
  Mat5 H;
  Vec5 g;
  build(x, &H, &g);
  return H;
}

FitState RangeFit::minimise(FitState x, int iterations, const Vec3* fixed, double* cost) const {
  Mat5 H;
  Vec5 g;
  double now = build(x, &H, &g);
  double damping = 1e-4;
  for (int k = 0; k < iterations; ++k) {
    Mat5 A = H;
    Vec5 rhs = -g;
    A.diagonal() *= 1 + damping;
    if (fixed) {
      Mat5 P = Mat5::Identity();
      P.topLeftCorner<3, 3>() -= *fixed * fixed->transpose();
      const double size = A.diagonal().head<3>().maxCoeff();
      A = P * A * P;
      A.topLeftCorner<3, 3>() += size * *fixed * fixed->transpose();
      rhs = P * rhs;
    }
    const Vec5 step = A.ldlt().solve(rhs);
    if (!step.allFinite()) break;
    const FitState next{x.a + step.head<3>(), x.b + step[3], x.s + step[4]};
    Mat5 H_next;
    Vec5 g_next;
    const double then = build(next, &H_next, &g_next);
    if (!(then <= now)) {
      damping = std::max(damping * 10, 1e-3);
      if (damping > 1e8 || step.norm() < 1e-10) break;
      continue;
    }
    const double gain = now - then;
    x = next;
    now = then;
    H = H_next;
    g = g_next;
    damping = std::max(damping * 0.1, 1e-9);
    if (step.norm() < 1e-11 * (1 + x.a.norm()) || gain < tolerance_ * std::min(now, 1.0)) break;
  }
  if (cost) *cost = now;
  return x;
}

std::vector<double> RangeFit::residuals(const FitState& x) const {
  std::vector<double> r(data_->size());
  const double grown = std::exp(x.s) - 1;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const Vec3 p = data_->p[i] + grown * (data_->p[i] - data_->p.back());
    r[i] = (data_->z[i] - (x.a - p).norm() - x.b) / data_->sigma[i];
  }
  return r;
}

}  // namespace vir::ranging
