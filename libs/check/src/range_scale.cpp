#include "range_scale.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vir/core/order_statistics.h"
#include "vir/ranging/range_correlation.h"

namespace vir::check {
namespace {

using Vec5 = Eigen::Matrix<double, 5, 1>;
using Mat5 = Eigen::Matrix<double, 5, 5>;

constexpr int kIterations = 30;
constexpr double kLeastNoise = 0.01;                // [m]
constexpr double kLeast = 0.015, kSigmas = 5;       // of an error, to speak of it
constexpr double kApart = 4, kApartAnyway = 0.015;  // sigmas, and error, between anchors

/// Anchor x y z, bias, error of the scale: what is thought of them beforehand.
const Vec5 kPrior = (Vec5() << 100, 100, 100, 10, 0.3).finished();

double residual(const AnchorFit& fit, std::size_t i, const Vec5& x) {
  return fit.ranges_m[i] - (1 + x[4]) * (x.head<3>() - fit.antennas_W[i]).norm() - x[3];
}

/// Normal equations with Cauchy's loss, in units of scale^2.
void normalEquations(const AnchorFit& fit, const Vec5& x, const Vec5& about, double scale, Mat5* H,
                     Vec5* g) {
  const Vec5 information = scale * scale * kPrior.cwiseAbs2().cwiseInverse();
  *H = Mat5(information.asDiagonal());
  *g = -information.cwiseProduct(x - about);
  for (std::size_t i = 0; i < fit.antennas_W.size(); ++i) {
    const Vec3 d = x.head<3>() - fit.antennas_W[i];
    const double distance = std::max(d.norm(), 1e-6);
    const double r = residual(fit, i, x);
    const double weight = 1 / (1 + r * r / (scale * scale));
    Vec5 J;
    J << (1 + x[4]) * d / distance, 1, distance;
    *H += weight * J * J.transpose();
    *g += weight * r * J;
  }
}

/// Of one of the ranges looked at: these are some of all, and neighbours are alike.
double varianceOf(const AnchorFit& fit, const Vec5& x) {
  std::vector<double> sizes;
  for (std::size_t i = 0; i < fit.times.size(); ++i) {
    sizes.push_back(std::abs(residual(fit, i, x)));
  }
  const double noise = std::max(medianInPlace(&sizes) / 0.6745, kLeastNoise);
  std::vector<ranging::RangeResidual> rest;
  for (std::size_t i = 0; i < fit.times.size(); ++i) {
    rest.push_back({fit.times[i], residual(fit, i, x), noise});
  }
  const double likeness = ranging::rangeCorrelation(rest).correlation_factor;
  const double independent = static_cast<double>(fit.used) / likeness;
  return noise * noise * static_cast<double>(fit.times.size()) / std::max(independent, 1.0);
}

/// From the solution without a factor.
RangeScale scaleOf(const AnchorFit& fit, bool held) {
  RangeScale out;
  const Vec5 about = (Vec5() << fit.p_W, fit.bias_m, 0).finished();
  const double scale = 3 * fit.noise_m;
  Vec5 x = about, g;
  Mat5 H;
  for (int i = 0; i <= kIterations; ++i) {
    normalEquations(fit, x, about, scale, &H, &g);
    if (held) H.topLeftCorner<3, 3>().diagonal().array() += 1e12;
    if (i < kIterations) x += H.ldlt().solve(g);
    if (!x.allFinite()) return out;
  }
  out.error = x[4];
  out.sigma = std::sqrt(H.inverse()(4, 4) * varianceOf(fit, x));
  out.found = std::isfinite(out.sigma) && out.sigma > 0 && std::abs(out.error) < 0.5;
  return out;
}

}  // namespace

RangeScale commonScale(const std::vector<const AnchorFit*>& fits, bool held) {
  std::vector<RangeScale> each;
  RangeScale out;
  double weights = 0, sum = 0;
  for (const AnchorFit* fit : fits) {
    const RangeScale s = scaleOf(*fit, held);
    if (!s.found) continue;
    each.push_back(s);
    weights += 1 / (s.sigma * s.sigma);
    sum += s.error / (s.sigma * s.sigma);
  }
  if (each.empty()) return out;
  out.error = sum / weights;
  out.sigma = 1 / std::sqrt(weights);
  out.anchors = static_cast<long>(each.size());
  const auto fits_in = [&out](const RangeScale& s) {
    return std::abs(s.error - out.error) < kApart * s.sigma + kApartAnyway;
  };
  out.found = std::abs(out.error) > kLeast && std::abs(out.error) > kSigmas * out.sigma &&
              std::all_of(each.begin(), each.end(), fits_in);
  return out;
}

}  // namespace vir::check
