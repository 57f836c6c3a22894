#include "vir/team/closed_form.h"

#include <gtest/gtest.h>

#include "vir_test_noise.h"

namespace vir::team {
namespace {

SharedAnchor anchorAt(const Vec3& p_A, const Vec3& p_B) {
  SharedAnchor anchor;
  anchor.p_A = p_A;
  anchor.p_B = p_B;
  return anchor;
}

TEST(ClosedForm, RightAngleByHand) {
  // Both worlds have the anchor at the origin. A at (3, 0), B at (4, 0) in its own world, 5 apart:
  // 25 = 9 + 16 - 2*3*4 cos(yaw), so the yaw is +-90 deg.
  MutualRange range;
  range.p_A = Vec3(3, 0, 0);
  range.p_B = Vec3(4, 0, 0);
  range.range_m = 5;
  range.sigma_m = 0.01;
  const YawPair pair = yawsFromRange(range, anchorAt(Vec3::Zero(), Vec3::Zero()));
  ASSERT_EQ(pair.problem, YawProblem::none);
  EXPECT_NEAR(pair.yaw_rad[0], M_PI / 2, 1e-12);
  EXPECT_NEAR(pair.yaw_rad[1], -M_PI / 2, 1e-12);
}

TEST(ClosedForm, OneOfTheTwoYawsIsTheTruthAndBothFitTheRange) {
  test::Noise noise(1);
  int fitting = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto random = [&] {
      return Vec3(5 * noise.normal(), 5 * noise.normal(), 2 * noise.normal());
    };
    const WorldTransform truth{2 * M_PI * (noise.uniform() - 0.5), random()};
    const Vec3 b = random();
    const SharedAnchor anchor = anchorAt(truth * b, b);
    MutualRange range;
    range.p_A = random();
    range.p_B = random();
    range.range_m = (range.p_A - truth * range.p_B).norm();
    range.sigma_m = 1e-6;
    const YawPair pair = yawsFromRange(range, anchor);
    ASSERT_EQ(pair.problem, YawProblem::none);
    double nearest = 10;
    for (const double yaw : pair.yaw_rad) {
      nearest = std::min(nearest, std::abs(wrapAngle(yaw - truth.yaw_rad)));
      const WorldTransform T = throughAnchor(yaw, anchor);
      EXPECT_NEAR((range.p_A - T * range.p_B).norm(), range.range_m, 1e-6);
      EXPECT_NEAR((T * anchor.p_B - anchor.p_A).norm(), 0, 1e-12);
    }
    fitting += nearest < 1e-6;
  }
  // Near the ends of acos a rounding error of the cosine is its root in the angle.
  EXPECT_GE(fitting, 999);
}

TEST(ClosedForm, RefusesWhatFitsNoYaw) {
  MutualRange range;
  range.p_A = Vec3(3, 0, 0);
  range.p_B = Vec3(4, 0, 0);
  range.sigma_m = 0.05;
  const SharedAnchor anchor = anchorAt(Vec3::Zero(), Vec3::Zero());
  for (const double metres : {0.5, 7.5}) {
    range.range_m = metres;
    EXPECT_EQ(yawsFromRange(range, anchor).problem, YawProblem::does_not_fit) << metres;
  }
  // Longer than the longest possible by less than the noise: the end of the arc.
  range.range_m = 7.1;
  const YawPair pair = yawsFromRange(range, anchor);
  ASSERT_EQ(pair.problem, YawProblem::none);
  EXPECT_NEAR(std::abs(pair.yaw_rad[0]), M_PI, 1e-9);
}

TEST(ClosedForm, KnowsTheAnchorsVertical) {
  MutualRange range;
  range.p_A = Vec3(1, 2, 7);
  range.p_B = Vec3(4, 0, 0);
  range.range_m = 5;
  range.sigma_m = 0.05;
  const SharedAnchor anchor = anchorAt(Vec3(1, 2, 3), Vec3::Zero());
  EXPECT_EQ(yawsFromRange(range, anchor).problem, YawProblem::on_the_vertical);
}

TEST(WorldTransform, InverseAndProduct) {
  const WorldTransform T{0.7, Vec3(1, 2, 3)}, S{-2.9, Vec3(-4, 0.5, 2)};
  const Vec3 p(0.3, -8, 1.5);
  EXPECT_NEAR((T.inverse() * (T * p) - p).norm(), 0, 1e-14);
  EXPECT_NEAR(((T * S) * p - T * (S * p)).norm(), 0, 1e-14);
  EXPECT_NEAR((T.pose() * p - T * p).norm(), 0, 1e-14);
}

}  // namespace
}  // namespace vir::team
