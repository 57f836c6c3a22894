#include "vir/check/range_bias.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "text.h"
#include "vir/core/order_statistics.h"
#include "vir/geometry/interpolation.h"

namespace vir::check {
namespace {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

constexpr std::size_t kFewest = 30, kMost = 3000, kMostAnchors = 32, kMostWaiting = 1000;
constexpr TimeNs kMaxGap = 200'000'000;
constexpr double kLeastNoise = 0.01;       // [m]
constexpr double kDoubtful = 0.15;         // [m] of bias
constexpr double kMostUncertainty = 0.05;  // [m] of the bias, to speak of it

/// Residuals at x = (anchor, bias) into normal equations, weighted by Cauchy's loss of `scale`.
double normalEquations(const std::vector<Vec3>& points, const std::vector<double>& ranges,
                       const Vec4& x, double scale, Mat4* H, Vec4* g) {
  H->setZero();
  g->setZero();
  double cost = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 d = x.head<3>() - points[i];
    const double distance = std::max(d.norm(), 1e-6);
    const double r = ranges[i] - distance - x[3];
    const double weight = 1 / (1 + r * r / (scale * scale));
    Vec4 J;
    J << d / distance, 1;
    *H += weight * J * J.transpose();
    *g += weight * r * J;
    cost += std::log1p(r * r / (scale * scale));
  }
  return cost;
}

double spreadOf(const std::vector<Vec3>& points, const std::vector<double>& ranges, const Vec4& x) {
  std::vector<double> rest;
  for (std::size_t i = 0; i < points.size(); ++i) {
    rest.push_back(std::abs(ranges[i] - (x.head<3>() - points[i]).norm() - x[3]));
  }
  return std::max(medianInPlace(&rest) / 0.6745, kLeastNoise);
}

/// From one start; the scale of the loss follows the spread. Returns the final cost at 0.1 m.
double descend(const std::vector<Vec3>& points, const std::vector<double>& ranges, Vec4* x) {
  Mat4 H;
  Vec4 g;
  double damping = 1e-3;
  for (int i = 0; i < 60; ++i) {
    const double scale = 2 * spreadOf(points, ranges, *x);
    const double cost = normalEquations(points, ranges, *x, scale, &H, &g);
    const Vec4 step =
        (H + damping * Mat4(H.diagonal().asDiagonal()) + 1e-9 * Mat4::Identity()).ldlt().solve(g);
    Mat4 ignored_H;
    Vec4 ignored_g;
    const Vec4 next = *x + step;
    if (normalEquations(points, ranges, next, scale, &ignored_H, &ignored_g) < cost) {
      *x = next;
      damping = std::max(damping / 5, 1e-9);
      if (step.norm() < 1e-7) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  return normalEquations(points, ranges, *x, 0.1, &H, &g);
}

}  // namespace

AnchorFit fitAnchor(const std::vector<Vec3>& points, const std::vector<double>& ranges) {
  AnchorFit fit;
  fit.used = static_cast<long>(points.size());
  if (points.size() < kFewest) return fit;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
  const double typical = median(ranges);
  double best = 1e300;
  Vec4 x = Vec4::Zero();
  for (int sx = -1; sx <= 1; ++sx) {
    for (int sy = -1; sy <= 1; ++sy) {
      for (int sz = -1; sz <= 1; ++sz) {
        Vec4 start = Vec4::Zero();
        start.head<3>() = middle + typical * Vec3(sx, sy, sz).normalized();
        if (!start.allFinite()) continue;
        const double cost = descend(points, ranges, &start);
        if (!start.allFinite() || cost >= best) continue;
        best = cost;
        x = start;
      }
    }
  }
  if (best == 1e300) return fit;
  fit.p_W = x.head<3>();
  fit.bias_m = x[3];
  fit.noise_m = spreadOf(points, ranges, x);
  Mat4 H;
  Vec4 g;
  normalEquations(points, ranges, x, 3 * fit.noise_m, &H, &g);
  const Eigen::SelfAdjointEigenSolver<Mat4> eigen(H);
  if (!(eigen.eigenvalues()(0) > 1e-6 * eigen.eigenvalues()(3))) return fit;
  fit.bias_sigma_m = fit.noise_m * std::sqrt(H.inverse()(3, 3));
  fit.found = std::isfinite(fit.bias_sigma_m);
  return fit;
}

void RangeBiasCheck::addTruth(const StampedPose& pose) {
  if (any_ && pose.t > last_.t && pose.t - last_.t <= kMaxGap) {
    for (const Range& r : waiting_) {
      if (r.t < last_.t || r.t > pose.t || !std::isfinite(r.range_m) || r.range_m <= 0) continue;
      if (anchors_.size() >= kMostAnchors && anchors_.count(r.anchor) == 0) continue;
      Seen& seen = anchors_[r.anchor];
      if (seen.ranges.size() >= kMost) continue;
      const double s = static_cast<double>(r.t - last_.t) / static_cast<double>(pose.t - last_.t);
      const Pose T = interpolate(last_.T_W_B, pose.T_W_B, s);
      seen.points_W.push_back(T * r.p_B_U);
      seen.ranges.push_back(r.range_m);
    }
  }
  // One that lies ahead of this pose waits for the next.
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(),
                                [&](const Range& r) { return r.t <= pose.t; }),
                 waiting_.end());
  if (waiting_.size() > kMostWaiting) waiting_.clear();
  last_ = pose;
  any_ = true;
}

std::vector<Finding> RangeBiasCheck::findings() const {
  std::vector<Finding> out;
  for (const auto& [id, seen] : anchors_) {
    const AnchorFit fit = fitAnchor(seen.points_W, seen.ranges);
    if (!fit.found || fit.bias_sigma_m > kMostUncertainty) continue;
    const bool wrong =
        std::abs(fit.bias_m) > kDoubtful && std::abs(fit.bias_m) > 5 * fit.bias_sigma_m;
    out.push_back({wrong ? Severity::doubtful : Severity::note, "range_bias", label_,
                   "anchor " + std::to_string(id) +
                       (wrong ? ": the ranges are too " +
                                    std::string(fit.bias_m > 0 ? "long" : "short") + " throughout"
                              : ": constant error against the ground truth"),
                   num(fit.bias_m) + " m, sigma " + num(fit.bias_sigma_m) + " m, by " +
                       std::to_string(fit.used) + " ranges along the true path",
                   wrong ? "calibrate the radios (vir-slam calibrate uwb), or take " +
                               num(fit.bias_m) + " m off"
                         : ""});
  }
  return out;
}

}  // namespace vir::check
