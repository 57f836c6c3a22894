/// Places that both robots' images show, beside ranges and in place of them.
#include <Eigen/Dense>
#include <cmath>
#include <limits>
//
#include <gtest/gtest.h>

#include "fake_solver.h"
#include "meetings.h"
#include "vir/team/meeting.h"
#include "vir/team/transform_tracker.h"

namespace vir::team {
namespace {

using test::errorOf;

constexpr double kPlaceSigma = 0.03, kYawSigma = 0.005;

/// Seen at `centre_B`, with an error as the covariance says, moved by `off` beside.
SharedPlaces placesAt(const WorldTransform& truth, const Vec3& centre_B, std::uint64_t seed,
                      const Vec3& off = Vec3::Zero()) {
  test::Noise noise(seed);
  SharedPlaces s;
  const double yaw = truth.yaw_rad + kYawSigma * noise.normal();
  const Vec3 e(noise.normal(), noise.normal(), noise.normal());
  const Vec3 centre_A = truth * centre_B + kPlaceSigma * e + off;
  s.T_A_B = {wrapAngle(yaw), centre_A - rotZ(yaw) * centre_B};
  // (yaw, centre) to (yaw, offset).
  Eigen::Matrix4d C = Eigen::Matrix4d::Zero(), J = Eigen::Matrix4d::Identity();
  C.diagonal() << kYawSigma * kYawSigma, Vec3::Constant(kPlaceSigma * kPlaceSigma);
  J.bottomLeftCorner<3, 1>() = -Vec3::UnitZ().cross(rotZ(yaw) * centre_B);
  s.covariance = J * C * J.transpose();
  s.centre_B = centre_B;
  s.places = 1;
  s.images = 3;
  s.since = s.until = fromSeconds(110);
  return s;
}

/// Both on straight lines at one height: two mirror images, and no range tells which.
test::MadeMeeting onLines(const WorldTransform& truth, int n, std::uint64_t seed) {
  test::Noise noise(seed);
  test::MadeMeeting out;
  for (int i = 0; i < n; ++i) {
    MutualRange r;
    r.t = fromSeconds(100 + 0.2 * i);
    r.sigma_m = 0.05;
    r.p_A = Vec3(0.1 * i, 0, 0);
    const Vec3 b = Vec3(4 - 0.05 * i, 1 + 0.08 * i, 0);
    r.p_B = truth.inverse() * b;
    r.range_m = (r.p_A - b).norm() + r.sigma_m * noise.normal();
    out.ranges.push_back(r);
  }
  return out;
}

TransformAnswer ask(const std::vector<MutualRange>& ranges, const SharedPlaces& places) {
  return findTransform(ranges, {}, test::plainTransformOptions(), {}, places);
}

TEST(SharedPlaces, OneTellsMirrorImagesApart) {
  const WorldTransform truth{1.1, Vec3(3, -2, 0.4)};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto made = onLines(truth, 60, seed);
    const TransformAnswer without = findTransform(made.ranges, {}, test::plainTransformOptions());
    EXPECT_NE(without.status, TransformStatus::unique) << seed;
    const TransformAnswer with =
        ask(made.ranges, placesAt(truth, truth.inverse() * Vec3(2, 1, 0), seed));
    ASSERT_EQ(with.status, TransformStatus::unique) << seed << ": " << with.reason;
    EXPECT_EQ(with.places, 1);
    EXPECT_EQ(with.solutions[0].places_used, 1);
    const Eigen::Vector4d e = errorOf(with.solutions[0].T_A_B, truth);
    EXPECT_LT(e.tail<3>().norm(), 0.25) << seed;
    EXPECT_LT(std::abs(e[0]), 0.03) << seed;
  }
}

TEST(SharedPlaces, NeedNoRange) {
  const WorldTransform truth{-2.9, Vec3(30, -20, 4)};
  double mean = 0;
  constexpr int kSeeds = 40;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const TransformAnswer answer = ask({}, placesAt(truth, Vec3(8, 5, 1), seed));
    ASSERT_EQ(answer.status, TransformStatus::unique) << answer.reason;
    EXPECT_EQ(answer.ranges, 0);
    EXPECT_FALSE(answer.height_open);
    const Eigen::Vector4d e = errorOf(answer.solutions[0].T_A_B, truth);
    mean += e.dot(answer.solutions[0].covariance.ldlt().solve(e)) / kSeeds;
  }
  EXPECT_GT(mean, 2.5);
  EXPECT_LT(mean, 6.0);
  EXPECT_EQ(findTransform({}, {}, test::plainTransformOptions()).status,
            TransformStatus::degenerate);
}

/// With ranges better than either alone, and as honest.
TEST(SharedPlaces, AreOneVerdictWithTheRanges) {
  test::Meeting m;
  m.ranges = 40;
  double ranges = 0, images = 0, both = 0, nees = 0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto made = test::meet(m, seed);
    const Vec3 at = made.ranges[20].p_B;
    const SharedPlaces places = placesAt(m.truth, at, 100 + seed);
    const TransformAnswer fused = ask(made.ranges, places);
    ASSERT_EQ(fused.status, TransformStatus::unique) << seed << ": " << fused.reason;
    const auto off = [&](const WorldTransform& T) { return (T * at - m.truth * at).squaredNorm(); };
    const TransformAnswer alone = findTransform(made.ranges, {}, test::plainTransformOptions());
    ranges += off(alone.solutions[0].T_A_B);
    images += off(places.T_A_B);
    both += off(fused.solutions[0].T_A_B);
    const Eigen::Vector4d e = errorOf(fused.solutions[0].T_A_B, m.truth);
    nees += e.dot(fused.solutions[0].covariance.ldlt().solve(e)) / kSeeds;
  }
  EXPECT_LT(both, ranges);
  EXPECT_LT(both, images);
  EXPECT_GT(nees, 2);
  EXPECT_LT(nees, 8);
}

TEST(SharedPlaces, ThatOnlyLookAlikeAreRefusedByTheRanges) {
  test::Meeting m;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto made = test::meet(m, seed);
    const SharedPlaces wrong = placesAt(m.truth, made.ranges[50].p_B, seed, Vec3(2.4, 0, 0));
    const TransformAnswer answer = ask(made.ranges, wrong);
    ASSERT_EQ(answer.status, TransformStatus::unique) << seed << ": " << answer.reason;
    EXPECT_EQ(answer.places, 1);
    EXPECT_EQ(answer.solutions[0].places_used, 0);
    EXPECT_LT(errorOf(answer.solutions[0].T_A_B, m.truth).norm(), 0.3) << seed;
  }
}

/// However few ranges there are, places that contradict them are not called the one answer.
TEST(SharedPlaces, AndAFewRangesThatContradictThemAreNotUnique) {
  test::Meeting m;
  int unique_wrong = 0, unique_right = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto made = test::meet(m, seed);
    for (const std::size_t n : {1, 2, 3, 5, 6, 8}) {
      std::vector<MutualRange> few;
      for (std::size_t i = 0; i < n; ++i) few.push_back(made.ranges[i * 180 / n]);
      const SharedPlaces right = placesAt(m.truth, made.ranges[50].p_B, seed);
      unique_right += ask(few, right).status == TransformStatus::unique ? 1 : 0;
      const SharedPlaces wrong = placesAt(m.truth, made.ranges[50].p_B, seed, Vec3(5, 4, 0));
      const TransformAnswer answer = ask(few, wrong);
      if (answer.status != TransformStatus::unique) continue;
      const bool off = errorOf(answer.solutions[0].T_A_B, m.truth).tail<3>().norm() > 1;
      // One circle of 3 m and more passes near many a wrong place: only n = 1 may be fooled.
      if (off && n > 1) ++unique_wrong;
    }
  }
  EXPECT_EQ(unique_wrong, 0);
  EXPECT_GE(unique_right, 110) << "of 120";
}

TEST(SharedPlaces, ThatCannotBeAreLeftOut) {
  const WorldTransform truth{0.3, Vec3(1, 2, 0)};
  const SharedPlaces good = placesAt(truth, Vec3(1, 1, 0), 1);
  std::vector<SharedPlaces> bad(6, good);
  bad[0].covariance(1, 2) = std::numeric_limits<double>::quiet_NaN();
  bad[1].covariance.setZero();
  bad[2].T_A_B.yaw_rad = std::numeric_limits<double>::infinity();
  bad[3].places = 0;
  bad[4].covariance(2, 2) = -1;
  bad[5].centre_B.x() = 1e12;
  for (std::size_t i = 0; i < bad.size(); ++i) {
    const TransformAnswer answer = ask({}, bad[i]);
    EXPECT_EQ(answer.status, TransformStatus::degenerate) << i;
    EXPECT_EQ(answer.places, 0) << i;
  }
}

TEST(SharedPlaces, OfAnotherWorldSayNothing) {
  test::Meeting m;
  m.ranges = 4;
  const auto made = test::meet(m, 3);
  TransformTrackerOptions options;
  options.transform = test::plainTransformOptions();
  TransformTracker tracker(options);
  SharedPlaces places = placesAt(m.truth, made.ranges[2].p_B, 3);
  places.segment_B = 1;
  tracker.setPlaces(places);
  for (const MutualRange& r : made.ranges) tracker.add(r, 0, 0);
  EXPECT_EQ(tracker.answer().status, TransformStatus::degenerate);
  for (const MutualRange& r : made.ranges) tracker.add(r, 0, 1);
  const TransformAnswer answer = tracker.answer();
  EXPECT_EQ(answer.status, TransformStatus::unique) << answer.reason;

  const WorldTransform T_new_A{0.7, Vec3(-4, 1, 2)};
  tracker.moveA(T_new_A);
  const TransformAnswer moved = tracker.answer();
  ASSERT_EQ(moved.status, TransformStatus::unique) << moved.reason;
  EXPECT_LT(errorOf(moved.solutions[0].T_A_B, T_new_A * answer.solutions[0].T_A_B).norm(), 1e-4);
}

/// A pair's solver hears of the places when both had been there.
TEST(SharedPlaces, AreToldToTheirPair) {
  std::vector<RobotRecord> robots(2);
  robots[0].name = "A";
  robots[1].name = "B";
  robots[1].id = 1;
  std::deque<test::SolverNotes> notes;
  std::vector<std::string> said;
  const LogSink log = [&](LogLevel level, const std::string& text) {
    if (level == LogLevel::warning) said.push_back(text);
  };
  const SharedPlaces places = placesAt({}, Vec3(1, 1, 0), 1);
  const Meeting meeting = meet(robots, {}, test::fakeSolvers(&notes, TransformStatus::degenerate),
                               log, {{{"A", "B"}, places}});
  ASSERT_EQ(notes.size(), 1u);
  ASSERT_TRUE(notes[0].places);
  EXPECT_EQ(notes[0].places->images, 3);
  ASSERT_TRUE(meeting.pairs[0].places);
  EXPECT_EQ(meeting.pairs[0].places->places, 1);
  EXPECT_TRUE(said.empty());
}

}  // namespace
}  // namespace vir::team
