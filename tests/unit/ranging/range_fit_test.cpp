/// The information that the fit of an anchor claims is the curvature of its cost, priors included.
#include "range_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vir::ranging {
namespace {

FitState moved(FitState x, int i, double by) {
  if (i < 3) x.a[i] += by;
  if (i == 3) x.b += by;
  if (i == 4) x.s += by;
  return x;
}

/// Second derivative of the cost by differences.
double curvature(const RangeFit& fit, const FitState& x, int i, int j) {
  constexpr double h = 1e-4;
  const auto at = [&](double a, double b) { return fit.cost(moved(moved(x, i, a), j, b)); };
  return (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4 * h * h);
}

/// Ranges without error to `x`, whose bias and scale are 0.
FitData rangesTo(const FitState& x) {
  FitData data;
  for (int k = 0; k < 12; ++k) {
    data.p.emplace_back(0.5 * k, std::sin(k), 0.3 * std::cos(2 * k));
    data.z.push_back((x.a - data.p.back()).norm());
    data.sigma.push_back(0.05 + 0.01 * k);
    data.drift.push_back(0);
  }
  return data;
}

void expectCurvature(const RangeFit& fit, const FitState& x) {
  const Mat5 H = fit.information(x);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      const double scale = std::sqrt(H(i, i) * H(j, j));
      EXPECT_NEAR(H(i, j), curvature(fit, x, i, j), 1e-4 * scale + 1e-6) << i << " " << j;
    }
  }
}

TEST(RangeFit, InformationIsTheCurvatureOfTheCost) {
  const FitState x{Vec3(3, -2, 1), 0, 0};
  const FitData data = rangesTo(x);
  const std::vector<char> all(data.size(), 1);
  AnchorInitOptions options;
  AnchorPrior prior;
  prior.p_W = x.a;
  prior.covariance = Vec3(0.04, 0.09, 0.25).asDiagonal();
  prior.covariance(0, 1) = prior.covariance(1, 0) = 0.02;
  for (const bool with_prior : {false, true}) {
    RangeFit fit(&data, &options, with_prior ? std::optional<AnchorPrior>(prior) : std::nullopt);
    expectCurvature(fit, x);  // near its minimum the robust loss is a square
    fit.setInliers(&all);
    fit.setFactors(1.5, 3);
    expectCurvature(fit, x);
  }
}

/// Where there is nothing to go by the priors are what is known.
TEST(RangeFit, WithoutRangesThePriorsAreAll) {
  const FitData none;
  AnchorInitOptions options;
  options.bias_sigma_m = 0.2;
  options.scale_sigma = 0.04;
  const Mat5 H = RangeFit(&none, &options, std::nullopt).information({});
  EXPECT_DOUBLE_EQ(H(3, 3), 1 / (0.2 * 0.2));
  EXPECT_DOUBLE_EQ(H(4, 4), 1 / (0.04 * 0.04));
  EXPECT_EQ((H - Mat5(H.diagonal().asDiagonal())).norm(), 0);
  EXPECT_LT(H.topLeftCorner(3, 3).norm(), 1e-6);
}

}  // namespace
}  // namespace vir::ranging
