#include "vir/types/interpolation.h"

#include <gtest/gtest.h>

namespace vir {
namespace {

constexpr TimeNs kMs = 1000000;

StampedPose at(TimeNs t, double x) { return {t, Pose(Quat::Identity(), Vec3(x, 0, 0))}; }

const Trajectory kPath{at(0, 0), at(100 * kMs, 1), at(700 * kMs, 7)};

TEST(PoseAt, BetweenItsNeighbours) {
  EXPECT_DOUBLE_EQ(poseAt(kPath, 25 * kMs, 200 * kMs)->p.x(), 0.25);
  EXPECT_EQ(poseAt(kPath, 100 * kMs, 200 * kMs)->p.x(), 1) << "as it stands in the list";
  EXPECT_EQ(poseAt(kPath, 700 * kMs, 0)->p.x(), 7) << "an exact stamp knows no gap";
}

TEST(PoseAt, NothingOutsideAndAcrossGaps) {
  EXPECT_FALSE(poseAt(kPath, -1, kMs));
  EXPECT_FALSE(poseAt(kPath, 700 * kMs + 1, 1000 * kMs));
  EXPECT_FALSE(poseAt(kPath, 101 * kMs, 599 * kMs));
  EXPECT_TRUE(poseAt(kPath, 101 * kMs, 600 * kMs));
  EXPECT_FALSE(poseAt({}, 0, kMs));
}

TEST(HeldPoseAt, HeldBeyondTheEnds) {
  EXPECT_EQ(heldPoseAt(kPath, -5 * kMs).p.x(), 0);
  EXPECT_EQ(heldPoseAt(kPath, 900 * kMs).p.x(), 7);
  EXPECT_DOUBLE_EQ(heldPoseAt(kPath, 400 * kMs).p.x(), 4);
}

}  // namespace
}  // namespace vir
