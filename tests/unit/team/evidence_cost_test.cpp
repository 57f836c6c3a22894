#include "evidence_cost.h"

#include <gtest/gtest.h>

#include "meetings.h"

namespace vir::team {
namespace {

TEST(EvidenceCost, IndependentRangesByHand) {
  // One range, no position errors, no slow error: r = 5.1 - 5, sigma 0.1, so r^2/sigma^2 = 1.
  std::vector<MutualRange> ranges(1);
  ranges[0].p_A = Vec3(3, 0, 0);
  ranges[0].p_B = Vec3(0, 4, 0);
  ranges[0].range_m = 5.1;
  TransformOptions options;
  options.slow_share = 0;
  options.robust = {0, 0};
  const std::vector<SharedAnchor> none;
  EXPECT_NEAR(EvidenceCost(ranges, none, options)(Vec4::Zero()), 1, 1e-9);
  // A position variance of 0.03 along the line of sight makes the variance 0.04: 0.01/0.04 + ln 4.
  ranges[0].cov_A = 0.03 * Mat3::Identity();
  EXPECT_NEAR(EvidenceCost(ranges, none, options)(Vec4::Zero()), 0.25 + std::log(4), 1e-9);
}

TEST(EvidenceCost, SlowErrorsEqualTheDenseGaussian) {
  // Against -2 log of the multivariate normal with covariance sigma^2 (1 + s^2 exp(-|dt|/tau)).
  test::Meeting m;
  m.ranges = 40;
  const auto made = test::meet(m, 3);
  TransformOptions options = test::plainTransformOptions();
  options.robust = {0, 0};
  const std::vector<SharedAnchor> none;
  const EvidenceCost cost(made.ranges, none, options);
  const Vec4 x = toVector(m.truth) + Vec4(0.01, 0.02, -0.03, 0.01);
  const int n = m.ranges;
  Eigen::MatrixXd C(n, n);
  Eigen::VectorXd r(n);
  for (int i = 0; i < n; ++i) {
    const MutualRange& a = made.ranges[static_cast<std::size_t>(i)];
    r[i] = a.range_m - (a.p_A - fromVector(x) * a.p_B).norm();
    for (int j = 0; j < n; ++j) {
      const double dt = std::abs(i - j) / m.rate_hz;
      C(i, j) = m.sigma_m * m.sigma_m *
                ((i == j ? 1 : 0) +
                 options.slow_share * options.slow_share * std::exp(-dt / options.slow_time_s));
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(C);
  double expected = llt.matrixL().solve(r).squaredNorm();
  for (int i = 0; i < n; ++i) {
    expected += 2 * std::log(llt.matrixLLT()(i, i) / m.sigma_m);
  }
  EXPECT_NEAR(cost(x), expected, 1e-6 * expected);
}

TEST(EvidenceCost, GradientIsThatOfTheCost) {
  test::Meeting m;
  m.ranges = 30;
  m.position_sigma_m = 0.1;
  const auto made = test::meet(m, 5);
  TransformOptions options;
  options.robust = {0, 0};  // with weights in the filter the gradient is an approximation
  // Isotropic covariances, so that nothing but the residuals depends on the yaw.
  options.drift_rad_per_sqrt_s = 0;
  const EvidenceCost cost(made.ranges, made.anchors, options);
  const Vec4 x = toVector(m.truth) + Vec4(0.02, 0.03, -0.05, 0.04);
  Mat4 H;
  Vec4 g;
  cost.linearise(x, &H, &g);
  for (int i = 0; i < 4; ++i) {
    Vec4 d = Vec4::Zero();
    d[i] = 1e-5;
    const double numeric = (cost(x + d) - cost(x - d)) / 2e-5;
    // The filter's gains depend on the directions to the other robot, which the gradient leaves
    // out.
    EXPECT_NEAR(2 * g[i], numeric, 0.02 * std::abs(numeric) + 1.0) << i;
  }
}

TEST(EvidenceCost, DescentEndsAtTheTruthWithoutNoise) {
  test::Meeting m;
  m.ranges = 30;
  auto made = test::meet(m, 7);
  for (MutualRange& r : made.ranges) r.range_m = (r.p_A - m.truth * r.p_B).norm();
  made.anchors.clear();
  const TransformOptions options;
  const EvidenceCost cost(made.ranges, made.anchors, options);
  Vec4 x = toVector(m.truth) + Vec4(0.1, 0.2, -0.2, 0.1);
  descend(cost, &x);
  // The flat bottom of the cost: where the descent ends there depends on how a compiler rounds.
  EXPECT_NEAR((x - toVector(m.truth)).norm(), 0, 1e-6);
}

}  // namespace
}  // namespace vir::team
