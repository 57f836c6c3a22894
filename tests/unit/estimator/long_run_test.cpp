/// The memory of an estimator does not grow with the hours, and no keyframe is lost to that.
#include <gtest/gtest.h>

#include <cmath>

#include "old_keyframes.h"
#include "vir/estimator/odometry_range_estimator.h"
#include "vir_test_heap.h"

namespace vir::estimator {
namespace {

/// Twice a second, along a circle of 20 m.
StampedPose onTheCircle(int i) {
  const double angle = 0.02 * i;
  const Vec3 p(20 * std::cos(angle) - 20, 20 * std::sin(angle), 0);
  return {1'000'000'000'000LL + i * 500'000'000LL, Pose(Quat(rotZ(angle)), p)};
}

/// What settled is told once, in order, and is what keyframes() goes on saying.
TEST(LongRun, KeyframesThatLeaveTheWindowOfTheOdometryAreTold) {
  OdometryRangeEstimator estimator({});
  const Vec3 anchor(5, -3, 2);
  std::vector<StampedPose> settled;
  for (int i = 0; i < 1000; ++i) {
    const StampedPose pose = onTheCircle(i);
    Range range;
    range.t = pose.t - 1;
    range.anchor = 1;
    range.range_m = (anchor - pose.T_W_B.p).norm();
    range.sigma_m = 0.1;
    estimator.addRange(range);
    estimator.addOdometry(pose.t, pose.T_W_B);
    for (const StampedPose& k : estimator.takeSettled()) settled.push_back(k);
  }
  EXPECT_TRUE(estimator.takeSettled().empty());
  const std::vector<StampedPose> all = estimator.keyframes();
  ASSERT_GT(settled.size(), 100u);
  ASSERT_LT(settled.size(), all.size());
  for (std::size_t i = 0; i < settled.size(); ++i) {
    EXPECT_EQ(settled[i].t, all[i].t);
    EXPECT_EQ(settled[i].T_W_B.p, all[i].T_W_B.p);
    if (i == 0) continue;
    EXPECT_LT(settled[i - 1].t, settled[i].t);
  }
}

/// 30 hours at one keyframe every two seconds.
TEST(OldKeyframes, MemoryStaysAsItIs) {
  if (!test::heapIsCounted()) GTEST_SKIP() << "the heap is the sanitizer's";
  OldKeyframes old;
  const test::HeapPeak heap;
  long after_a_while = 0;
  for (int i = 0; i < 54000; ++i) {
    old.add({onTheCircle(i), Pose(), 1, Vec3::Zero(), Eigen::Vector4d::Zero()});
    old.takeSettled();
    if (i == 9000) after_a_while = heap.now();
  }
  EXPECT_EQ(heap.now(), after_a_while);
}

TEST(OldKeyframes, AllAreTakenOnceAndSomeAreKept) {
  OldKeyframes old;
  std::vector<StampedPose> taken;
  for (int i = 0; i < 20000; ++i) {
    old.add({onTheCircle(i), Pose(), 1, Vec3::Zero(), Eigen::Vector4d::Zero()});
    if (i % 7 != 0) continue;
    for (const StampedPose& k : old.takeSettled()) taken.push_back(k);
  }
  for (const StampedPose& k : old.takeSettled()) taken.push_back(k);
  EXPECT_TRUE(old.takeSettled().empty());
  ASSERT_EQ(taken.size(), 20000u);
  for (int i = 0; i < 20000; ++i) {
    EXPECT_EQ(taken[static_cast<std::size_t>(i)].t, onTheCircle(i).t);
  }
  EXPECT_GE(old.kept().size(), 4096u);
  EXPECT_LT(old.kept().size(), 8192u);
  EXPECT_EQ(old.kept().front().t, taken.front().t);
}

}  // namespace
}  // namespace vir::estimator
