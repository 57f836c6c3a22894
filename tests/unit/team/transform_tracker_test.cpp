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

/// A is found in a map on the way: half of the ranges are of its own frame, half of the map's.
TEST(TransformTracker, AFrameThatAGoesOnInIsNoNewWorld) {
  test::Meeting m;
  const auto made = test::meet(m, 6);
  const WorldTransform T_new_A{2.1, Vec3(-4, 7, 0.5)};
  TransformTracker still(plain()), moved(plain());
  const std::size_t half = made.ranges.size() / 2;
  for (std::size_t k = 0; k < made.ranges.size(); ++k) {
    MutualRange r = made.ranges[k];
    still.add(r);
    if (k == half) {
      EXPECT_EQ(moved.answer().status, still.answer().status);
      moved.moveA(T_new_A);
    }
    if (k >= half) {
      r.p_A = T_new_A * r.p_A;
      r.cov_A = rotZ(T_new_A.yaw_rad) * r.cov_A * rotZ(T_new_A.yaw_rad).transpose();
    }
    moved.add(r);
  }
  const TransformAnswer before = still.answer(), after = moved.answer();
  ASSERT_EQ(after.status, TransformStatus::unique) << after.reason;
  EXPECT_EQ(moved.restarts(), 0);
  const WorldTransform expected = T_new_A * before.solutions[0].T_A_B;
  EXPECT_LT((after.solutions[0].T_A_B.t_m - expected.t_m).norm(), 1e-3);
  EXPECT_NEAR(wrapAngle(after.solutions[0].T_A_B.yaw_rad - expected.yaw_rad), 0, 1e-4);
  const Mat3 R = rotZ(T_new_A.yaw_rad);
  const Mat3 C = R * before.solutions[0].covariance.bottomRightCorner<3, 3>() * R.transpose();
  EXPECT_LT((after.solutions[0].covariance.bottomRightCorner<3, 3>() - C).norm(), 0.02 * C.norm());
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

/// Level robots that drive alike, 3.7 m apart, whose estimators say 0.25 m of paths that are right
/// to 0.03 m: their distance hardly changes, so that one straight above the other would explain it
/// as well, and without any of that uncertainty.
TEST(TransformTracker, RobotsThatDriveAlikeAreNotTakenForOneAboveTheOther) {
  int wrong = 0, taken_back = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    test::Noise noise(seed);
    const WorldTransform truth{0, Vec3(2.2, 2.97, 0)};
    std::vector<test::SlowNoise> slow;
    for (int i = 0; i < 4; ++i) slow.emplace_back(&noise, 30);
    double phase[6];
    for (double& p : phase) p = 2 * M_PI * noise.uniform();
    Mat3 said = Mat3::Identity() * 0.25 * 0.25;
    said(2, 2) = 1e-6;
    TransformTracker tracker;
    SharedAnchor anchor;
    anchor.p_A = Vec3(4 + 0.1 * noise.normal(), -3.9 + 0.1 * noise.normal(), 0);
    anchor.p_B = Vec3(4, -3.9, 0) - truth.t_m + Vec3(0.1 * noise.normal(), 0.1 * noise.normal(), 0);
    anchor.cov_A = Vec3(0.02, 0.02, 100).asDiagonal();
    anchor.cov_B = Vec3(0.04, 0.04, 100).asDiagonal();
    bool was_unique = false;
    for (int i = 0; i < 480; ++i) {
      const double t = 0.16 * i;
      const auto wave = [&](int k, double period) {
        return std::sin(2 * M_PI * t / period + phase[k]);
      };
      const Vec3 way(1.1 * wave(0, 31) + 0.4 * wave(1, 17), 1.2 * wave(2, 26) + 0.3 * wave(3, 13),
                     0);
      const auto error = [&](std::size_t k) {
        return Vec3(0.03 * slow[k].next(0.16), 0.03 * slow[k + 1].next(0.16), 0);
      };
      MutualRange r;
      r.t = fromSeconds(100 + t);
      r.sigma_m = 0.044;
      r.range_m = truth.t_m.norm() + 0.04 * noise.normal();
      r.p_A = way + error(0);
      r.p_B = way + error(2);
      r.cov_A = r.cov_B = said;
      tracker.add(r);
      if (i % 16 != 15) continue;
      tracker.setAnchors({anchor});
      const TransformAnswer answer = tracker.answer();
      const bool unique = answer.status == TransformStatus::unique;
      taken_back += was_unique && !unique ? 1 : 0;
      was_unique = unique;
      if (!unique) continue;
      const Vec3 off = answer.solutions[0].T_A_B * r.p_B - truth * r.p_B;
      wrong += off.head<2>().norm() > 1 ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 0) << "of 120 answers";
  EXPECT_EQ(taken_back, 0);
}

}  // namespace
}  // namespace vir::team
