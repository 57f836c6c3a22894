#include "vir/ranging/robust_range.h"

#include <algorithm>
#include <cmath>

namespace vir::ranging {
namespace {

/// Beyond this a residual is no different to any loss, and its square still fits into a double.
constexpr double kLargest = 1e12;
constexpr double kLargestRatio = 1e100;  // to a tiny delta

/// sqrt(log(1 + x) / x) for x >= 0, series near 0 where the quotient is 0/0.
double cauchyRatio(double x) {
  if (x < 1e-5) return 1 - x / 4 + 13 * x * x / 96;
  return std::sqrt(std::log1p(x) / x);
}

}  // namespace

double RobustRange::Value::influence() const { return std::sqrt(weight) * de_dr; }

RobustRange::Value RobustRange::evaluate(double r) const {
  if (std::isnan(r)) return {0, 0, 0};
  r = std::clamp(r, -kLargest, kLargest);
  const double delta = r < 0 ? huber_delta : nlos_delta;
  if (!(delta > 0)) return {r, 1, 1};
  const double q = std::clamp(r / delta, -kLargestRatio, kLargestRatio);
  const double x = q * q;
  if (r < 0) {
    const double s = std::sqrt(1 + x);
    const double ratio = std::sqrt(2 / (s + 1));  // e / r
    return {r * ratio, 1 / (s * ratio), ratio * ratio};
  }
  const double ratio = cauchyRatio(x);
  return {r * ratio, 1 / ((1 + x) * ratio), ratio * ratio};
}

double RobustRange::loss(double r) const {
  const double e = evaluate(r).e;
  return 0.5 * e * e;
}

}  // namespace vir::ranging
