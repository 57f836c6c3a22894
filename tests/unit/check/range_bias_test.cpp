#include "vir/check/range_bias.h"

#include <gtest/gtest.h>

#include <cmath>

#include "found.h"
#include "vir/core/random.h"

namespace vir::check {
namespace {

/// A flight about a room with an anchor in a corner; every tenth range is a metre too long.
std::vector<Finding> findingsOf(double bias, std::vector<AnchorFit>* fits = nullptr) {
  RangeBiasCheck check("UWB0");
  Random random(4);
  const Vec3 anchor(4, -3, 2.5), antenna(0.1, 0, 0.05);
  std::vector<Vec3> points;
  std::vector<double> ranges;
  for (int i = 0; i < 16000; ++i) {
    const double t = 0.005 * i;
    const Pose T(expQuat(Vec3(0, 0, 0.4 * t)),
                 Vec3(2.5 * std::sin(0.6 * t), 2 * std::cos(0.5 * t), 1.2 + std::sin(0.9 * t)));
    if (i % 10 == 5) {
      Range r;
      r.t = fromSeconds(t);
      r.anchor = 7;
      r.p_B_U = antenna;
      r.range_m =
          (anchor - T * antenna).norm() + bias + 0.05 * random.normal() + (i % 100 == 5 ? 1.0 : 0);
      check.add(r);
      points.push_back(T * antenna);
      ranges.push_back(r.range_m);
    }
    check.addTruth({fromSeconds(t), T});
  }
  if (fits != nullptr) fits->push_back(fitAnchor(points, ranges));
  return check.findings();
}

TEST(RangeBias, IsFoundAgainstTheTruth) {
  std::vector<AnchorFit> fits;
  EXPECT_EQ(seriousKinds(findingsOf(0.6, &fits)), Kinds{"range_bias"});
  ASSERT_TRUE(fits[0].found);
  EXPECT_NEAR(fits[0].bias_m, 0.6, 0.1);
  EXPECT_LT((fits[0].p_W - Vec3(4, -3, 2.5)).norm(), 0.15);
  EXPECT_LT(fits[0].bias_sigma_m, 0.05);
  EXPECT_EQ(seriousKinds(findingsOf(-0.4)), Kinds{"range_bias"});
}

TEST(RangeBias, NoBiasIsANote) {
  const auto findings = findingsOf(0);
  EXPECT_EQ(seriousKinds(findings), Kinds{});
  EXPECT_EQ(findings.size(), 1u);
}

TEST(RangeBias, AStraightLineSaysNothing) {
  std::vector<Vec3> points;
  std::vector<double> ranges;
  for (int i = 0; i < 100; ++i) {
    points.emplace_back(0.05 * i, 0, 0);
    ranges.push_back((Vec3(2, 3, 0) - points.back()).norm());
  }
  EXPECT_FALSE(fitAnchor(points, ranges).found);
  EXPECT_FALSE(fitAnchor({}, {}).found);
}

}  // namespace
}  // namespace vir::check
