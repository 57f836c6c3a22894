#include "vir/evaluation/association.h"

#include <gtest/gtest.h>

namespace vir::evaluation {
namespace {

constexpr TimeNs kSecond = 1000000000;

StampedPose at(double s, double x, double yaw = 0) {
  return {fromSeconds(s), Pose(expQuat(Vec3(0, 0, yaw)), Vec3(x, 0, 0))};
}

TEST(Associate, InterpolatesBetweenNeighbours) {
  const Trajectory ref{at(0, 0, 0), at(0.1, 1, 0.2), at(0.2, 3, 0.2)};
  const Trajectory est{at(0, 7), at(0.025, 8), at(0.1, 9), at(0.175, 9)};
  const Association a = associate(ref, est, {});
  ASSERT_EQ(a.pairs.size(), 4u);
  EXPECT_DOUBLE_EQ(a.pairs[0].reference.p.x(), 0);
  EXPECT_DOUBLE_EQ(a.pairs[1].reference.p.x(), 0.25);  // a quarter of the way from 0 to 1
  EXPECT_NEAR(logQuat(a.pairs[1].reference.q).z(), 0.05, 1e-15);
  EXPECT_DOUBLE_EQ(a.pairs[2].reference.p.x(), 1);
  EXPECT_DOUBLE_EQ(a.pairs[3].reference.p.x(), 2.5);
  EXPECT_EQ(a.pairs[1].estimate.p.x(), 8);
  EXPECT_DOUBLE_EQ(a.coverage, 0.175 / 0.2);
}

TEST(Associate, NeverExtrapolates) {
  const Trajectory ref{at(1, 0), at(1.05, 1)};
  const Association a = associate(ref, {at(0.999999999, 0), at(1.05, 0), at(1.050000001, 0)}, {});
  ASSERT_EQ(a.pairs.size(), 1u);
  EXPECT_EQ(a.before, 1);
  EXPECT_EQ(a.after, 1);
}

TEST(Associate, GapsAreNotBridgedButExactStampsCount) {
  const Trajectory ref{at(0, 0), at(0.1, 0), at(2, 0), at(2.1, 0)};
  AssociationOptions options;
  options.max_gap = kSecond / 10;
  const Association a = associate(ref, {at(0.05, 0), at(0.1, 0), at(1, 0), at(2, 0)}, options);
  EXPECT_EQ(a.pairs.size(), 3u);
  EXPECT_EQ(a.in_gap, 1);
}

/// The estimate is interpolated at the stamps of a reference of 1 Hz that is off by 13 ms.
TEST(Associate, TheDenserOneIsInterpolated) {
  Trajectory ref, est;
  for (int i = 0; i <= 200; ++i) est.push_back(at(0.05 * i, 0.1 * i));
  for (int i = 0; i < 10; ++i) ref.push_back(at(i + 0.013, 2 * (i + 0.013)));
  const Association a = associate(ref, est, {});
  EXPECT_TRUE(a.estimate_interpolated);
  ASSERT_EQ(a.pairs.size(), 10u);
  for (const PosePair& p : a.pairs) EXPECT_NEAR(p.reference.p.x(), p.estimate.p.x(), 1e-12);
  EXPECT_DOUBLE_EQ(a.coverage, 1);
}

TEST(Associate, HolesAreNotCovered) {
  Trajectory ref, est;
  for (int i = 0; i <= 100; ++i) {
    ref.push_back(at(0.1 * i, 0));
    if (i <= 20 || i >= 60) est.push_back(at(0.1 * i, 0));
  }
  const Association a = associate(ref, est, {});
  EXPECT_NEAR(a.reference_s, 10, 1e-9);
  EXPECT_NEAR(a.covered_s, 6, 1e-9);
  EXPECT_NEAR(a.coverage, 0.6, 1e-9);
}

TEST(Associate, EmptyAndSinglePoses) {
  EXPECT_TRUE(associate({}, {}, {}).pairs.empty());
  EXPECT_EQ(associate({}, {at(0, 0)}, {}).before, 1);
  EXPECT_EQ(associate({at(0, 0)}, {}, {}).coverage, 0);
  EXPECT_EQ(associate({at(0, 0)}, {at(0, 0)}, {}).coverage, 1);
  EXPECT_EQ(associate({at(0, 0)}, {at(1, 0)}, {}).after, 1);
}

}  // namespace
}  // namespace vir::evaluation
