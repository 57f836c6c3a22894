#include "vir/team/transform_tracker.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meetings.h"

namespace vir::team {
namespace {

TransformTrackerOptions plain() {
  TransformTrackerOptions o;
  o.transform = test::plainTransformOptions();
  return o;
}

TEST(TransformTracker, FindsWhatTheRangesSay) {
  test::Meeting m;
  const auto made = test::meet(m, 1);
  TransformTracker tracker(plain());
  EXPECT_EQ(tracker.answer().status, TransformStatus::degenerate);
  for (const MutualRange& r : made.ranges) tracker.add(r);
  const TransformAnswer answer = tracker.answer();
  ASSERT_EQ(answer.status, TransformStatus::unique) << answer.reason;
  EXPECT_LT(test::errorOf(answer.solutions[0].T_A_B, m.truth).norm(), 0.3);
}

TEST(TransformTracker, MemoryStaysBoundedAndSpansTheMeeting) {
  test::Meeting m;
  m.ranges = 5000;
  const auto made = test::meet(m, 2);
  TransformTrackerOptions options = plain();
  options.max_ranges = 200;
  TransformTracker tracker(options);
  for (const MutualRange& r : made.ranges) {
    tracker.add(r);
    ASSERT_LE(tracker.kept(), 200u);
  }
  EXPECT_EQ(tracker.seen(), 5000);
  const TransformAnswer answer = tracker.answer();
  ASSERT_EQ(answer.status, TransformStatus::unique);
  EXPECT_LT(test::errorOf(answer.solutions[0].T_A_B, m.truth).norm(), 0.3);
}

TEST(TransformTracker, ANewSegmentIsANewWorld) {
  test::Meeting before, after;
  after.truth = {-2, Vec3(10, 4, -1)};
  const auto one = test::meet(before, 3), two = test::meet(after, 4);
  TransformTracker tracker(plain());
  for (const MutualRange& r : one.ranges) tracker.add(r, 0, 0);
  tracker.setAnchors(one.anchors);
  for (MutualRange r : two.ranges) {
    r.t += fromSeconds(1000);
    tracker.add(r, 0, 1);
  }
  tracker.add(one.ranges.back(), 0, 0);
  EXPECT_EQ(tracker.restarts(), 1);
  EXPECT_EQ(tracker.seen(), after.ranges) << "the range of the old world is left out";
  const TransformAnswer answer = tracker.answer();
  ASSERT_EQ(answer.status, TransformStatus::unique) << answer.reason;
  EXPECT_LT(test::errorOf(answer.solutions[0].T_A_B, after.truth).norm(), 0.3);
}

TEST(TransformTracker, FollowsWorldsThatSlideAgainstEachOther) {
  // B's world turns by 17 deg and slides by 1.8 m within 200 s; the answer is to hold at the end.
  test::Meeting m;
  m.ranges = 1000;
  const auto made = test::meet(m, 5);
  const auto truthAt = [&](double part) {
    return WorldTransform{m.truth.yaw_rad + 0.3 * part, m.truth.t_m + Vec3(1.5, 0.9, 0) * part};
  };
  TransformTrackerOptions drifting;
  drifting.transform.drift_m_per_sqrt_s = 0.1;
  drifting.transform.drift_rad_per_sqrt_s = 0.02;
  TransformTracker modelled(drifting), rigid(plain());
  for (std::size_t i = 0; i < made.ranges.size(); ++i) {
    MutualRange r = made.ranges[i];
    const Vec3 b = m.truth * r.p_B;
    r.p_B = truthAt(static_cast<double>(i) / 1000).inverse() * b;
    modelled.add(r);
    rigid.add(r);
  }
  const Vec3 last = made.ranges.back().p_B;
  const auto errorNow = [&](const TransformAnswer& a) {
    return (a.solutions.at(0).T_A_B * last - truthAt(1) * last).norm();
  };
  const TransformAnswer answer = modelled.answer();
  EXPECT_EQ(answer.status, TransformStatus::unique) << answer.reason;
  EXPECT_LT(errorNow(answer), 0.4);
  EXPECT_GT(errorNow(rigid.answer()), 2 * errorNow(answer));
}

TEST(TransformTracker, WhatIsUniqueOnTwoFloorsStaysSo) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::Meeting m;
    m.height_m = 0;
    m.ranges = 600;
    m.slow_share = 0.7;
    m.truth.t_m.z() = -0.6;
    auto made = test::meet(m, seed);
    TransformTracker tracker;
    bool was_unique = false;
    for (std::size_t i = 0; i < made.ranges.size(); ++i) {
      MutualRange r = made.ranges[i];
      const double before = (r.p_A - m.truth * r.p_B).norm();
      r.p_A.z() = r.p_B.z() = 0;
      r.range_m += (r.p_A - m.truth * r.p_B).norm() - before;
      tracker.add(r);
      if (i % 20 != 19) continue;
      const bool unique = tracker.answer().status == TransformStatus::unique;
      EXPECT_TRUE(unique || !was_unique) << seed << " after " << i;
      was_unique = was_unique || unique;
    }
    EXPECT_TRUE(was_unique) << seed;
  }
}

/// As when the common anchor is lost: the same transform, no longer certain enough to be found.
TEST(TransformTracker, WhatIsUniqueStaysSoWhenItBecomesLessCertain) {
  int open_alone = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    test::Meeting m;
    m.ranges = 24;
    const auto made = test::meet(m, seed);
    TransformTracker tracker;
    for (const MutualRange& r : made.ranges) tracker.add(r);
    tracker.setAnchors(made.anchors);
    if (tracker.answer().status != TransformStatus::unique) continue;
    tracker.setAnchors({});
    const TransformAnswer alone = findTransform(made.ranges, {}, TransformOptions(), {m.truth});
    if (alone.status != TransformStatus::degenerate || alone.solutions.empty()) continue;
    const auto e = test::errorOf(alone.solutions[0].T_A_B, m.truth);
    if (!(std::abs(e[0]) < 0.05 && e.tail<3>().norm() < 0.3)) continue;
    ++open_alone;
    const TransformAnswer answer = tracker.answer();
    EXPECT_EQ(answer.status, TransformStatus::unique) << seed << " " << answer.reason;
    ASSERT_EQ(answer.solutions.size(), 1u);
    const double known = std::sqrt(answer.solutions[0].covariance(0, 0));
    EXPECT_NEAR(known, std::sqrt(alone.solutions[0].covariance(0, 0)), 0.05)
        << "how little is known is told";
  }
  EXPECT_GE(open_alone, 1) << "else this tests nothing";
}

}  // namespace
}  // namespace vir::team
