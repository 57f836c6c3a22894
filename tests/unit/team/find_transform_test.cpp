#include "vir/team/find_transform.h"

#include <Eigen/Dense>
//
#include <gtest/gtest.h>

#include "meetings.h"
#include "vir/team/joint_solution.h"
#include "vir/team/transform_tracker.h"

namespace vir::team {
namespace {

using test::errorOf;

TEST(TeamOptions, AProgramsValuesAreCheckedAsAFilesAre) {
  TransformOptions transform;
  transform.false_alarm = 0;
  EXPECT_THROW(findTransform({}, {}, transform), std::invalid_argument);
  TransformTrackerOptions tracker;
  tracker.max_ranges = 0;
  EXPECT_THROW(TransformTracker{tracker}, std::invalid_argument);
  JointOptions joint;
  joint.iterations = 0;
  EXPECT_THROW(solveJointly({}, {}, joint), std::invalid_argument);
}

struct Nees {
  double mean = 0;
  int unique = 0, wrong = 0;
};

Nees neesOf(const test::Meeting& m, int meetings, bool anchor) {
  Nees out;
  for (int seed = 1; seed <= meetings; ++seed) {
    auto made = test::meet(m, static_cast<std::uint64_t>(seed));
    if (!anchor) made.anchors.clear();
    const TransformAnswer answer =
        findTransform(made.ranges, made.anchors, test::plainTransformOptions());
    if (answer.status != TransformStatus::unique) continue;
    ++out.unique;
    const Eigen::Vector4d e = errorOf(answer.solutions[0].T_A_B, m.truth);
    const double nees = e.dot(answer.solutions[0].covariance.ldlt().solve(e));
    if (nees > 50) ++out.wrong;
    out.mean += nees;
  }
  out.mean /= std::max(out.unique, 1);
  return out;
}

void expectHonest(const Nees& n, int meetings) {
  EXPECT_GE(n.unique, meetings * 9 / 10);
  EXPECT_EQ(n.wrong, 0);
  EXPECT_GT(n.mean, 0.5 * 4);
  EXPECT_LT(n.mean, 2.0 * 4);
}

TEST(FindTransform, HonestCovarianceWithAnchor) {
  test::Meeting m;
  m.slow_share = 0.7;
  m.position_sigma_m = 0.05;
  expectHonest(neesOf(m, 200, true), 200);
}

TEST(FindTransform, HonestCovarianceWithoutAnchor) {
  test::Meeting m;
  m.slow_share = 0.7;
  m.position_sigma_m = 0.05;
  expectHonest(neesOf(m, 200, false), 200);
}

TEST(FindTransform, HonestCovarianceWithWhiteErrors) {
  // The model expects slow errors; the residuals say that there are none.
  test::Meeting m;
  expectHonest(neesOf(m, 200, false), 200);
  expectHonest(neesOf(m, 200, true), 200);
}

TEST(FindTransform, HonestCovarianceWithMoreCorrelationThanExpected) {
  test::Meeting m;
  m.slow_share = 1.5;
  m.slow_time_s = 4;
  const Nees n = neesOf(m, 200, false);
  EXPECT_EQ(n.wrong, 0);
  EXPECT_LT(n.mean, 2.0 * 4);
}

TEST(FindTransform, ThirtyPercentOutliers) {
  for (const bool anchor : {true, false}) {
    test::Meeting m;
    m.nlos = 0.3;
    m.slow_share = 0.7;
    m.position_sigma_m = 0.02;
    int unique = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      auto made = test::meet(m, seed);
      if (!anchor) made.anchors.clear();
      const TransformAnswer answer =
          findTransform(made.ranges, made.anchors, test::plainTransformOptions());
      if (answer.status != TransformStatus::unique) continue;
      ++unique;
      const auto e = errorOf(answer.solutions[0].T_A_B, m.truth);
      EXPECT_LT(e.tail<3>().norm(), 0.4) << seed;
      EXPECT_LT(std::abs(e[0]), 0.1) << seed;
      EXPECT_GT(answer.solutions[0].rejected, 20);
    }
    EXPECT_GE(unique, 90) << "anchor " << anchor;
  }
}

TEST(FindTransform, NeverWronglyUniqueWhileRangesComeIn) {
  // The question is asked again after every few ranges, as a running robot does.
  test::Meeting m;
  m.slow_share = 0.7;
  m.position_sigma_m = 0.05;
  m.ranges = 120;
  for (const bool anchor : {true, false}) {
    int wrong = 0, decided = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      const auto made = test::meet(m, 1000 + seed);
      for (std::size_t n = 2; n <= made.ranges.size(); n += 10) {
        const std::vector<MutualRange> some(made.ranges.begin(),
                                            made.ranges.begin() + static_cast<long>(n));
        const TransformAnswer answer =
            findTransform(some, anchor ? made.anchors : std::vector<SharedAnchor>(),
                          test::plainTransformOptions());
        if (answer.status != TransformStatus::unique) continue;
        ++decided;
        const auto e = errorOf(answer.solutions[0].T_A_B, m.truth);
        const double nees = e.dot(answer.solutions[0].covariance.ldlt().solve(e));
        wrong += nees > 60;
      }
    }
    EXPECT_EQ(wrong, 0) << "anchor " << anchor;
    EXPECT_GT(decided, 150);
  }
}

TEST(FindTransform, AWrongAnchorIsOutvotedByTheRanges) {
  test::Meeting m;
  m.position_sigma_m = 0.03;
  int unique = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    auto made = test::meet(m, seed);
    made.anchors[0].p_B += Vec3(2, -1, 0);
    const TransformAnswer answer =
        findTransform(made.ranges, made.anchors, test::plainTransformOptions());
    if (answer.status != TransformStatus::unique) continue;
    ++unique;
    EXPECT_LT(errorOf(answer.solutions[0].T_A_B, m.truth).norm(), 0.4) << seed;
    EXPECT_EQ(answer.solutions[0].anchors_used, 0);
  }
  EXPECT_GE(unique, 27);
}

TEST(FindTransform, RangesToSomebodyElseAreInconsistent) {
  test::Meeting m;
  int inconsistent = 0, unique = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    auto made = test::meet(m, seed);
    const auto other = test::meet(m, seed + 500);
    for (std::size_t i = 0; i < made.ranges.size(); ++i) {
      made.ranges[i].p_B = other.ranges[i].p_B;
    }
    const TransformAnswer answer =
        findTransform(made.ranges, made.anchors, test::plainTransformOptions());
    inconsistent += answer.status == TransformStatus::inconsistent;
    unique += answer.status == TransformStatus::unique;
  }
  EXPECT_EQ(unique, 0);
  EXPECT_GE(inconsistent, 25);
}

TEST(FindTransform, SeveralAnchorsFixTheYawWithOneRange) {
  test::Meeting m;
  m.anchor_sigma_m = 0.03;
  auto made = test::meet(m, 11);
  SharedAnchor second = made.anchors[0];
  second.id = 2;
  const Vec3 at(4, 5, 0.5);
  second.p_A = at;
  second.p_B = m.truth.inverse() * at;
  made.anchors.push_back(second);
  made.ranges.resize(1);
  const TransformAnswer answer =
      findTransform(made.ranges, made.anchors, test::plainTransformOptions());
  ASSERT_EQ(answer.status, TransformStatus::unique) << answer.reason;
  EXPECT_LT(errorOf(answer.solutions[0].T_A_B, m.truth).norm(), 0.2);
}

TEST(FindTransform, BadInputIsCountedAndHarmless) {
  test::Meeting m;
  auto made = test::meet(m, 12);
  made.ranges[3].range_m = std::nan("");
  made.ranges[4].range_m = -1;
  made.ranges[5].sigma_m = 0;
  made.ranges[6].p_A.x() = INFINITY;
  made.ranges[7].cov_B(1, 1) = std::nan("");
  made.anchors[0].p_A.z() = std::nan("");
  const TransformAnswer answer =
      findTransform(made.ranges, made.anchors, test::plainTransformOptions());
  EXPECT_EQ(answer.ignored, 5);
  EXPECT_EQ(answer.ranges, m.ranges - 5);
  EXPECT_EQ(answer.status, TransformStatus::unique);
}

TEST(FindTransform, SameAnswerTwice) {
  test::Meeting m;
  m.nlos = 0.2;
  const auto made = test::meet(m, 13);
  const auto a = findTransform(made.ranges, {}, TransformOptions());
  const auto b = findTransform(made.ranges, {}, TransformOptions());
  ASSERT_EQ(a.solutions.size(), b.solutions.size());
  EXPECT_EQ(a.solutions[0].T_A_B.yaw_rad, b.solutions[0].T_A_B.yaw_rad);
  EXPECT_EQ(a.solutions[0].T_A_B.t_m, b.solutions[0].T_A_B.t_m);
}

TEST(FindTransform, RobotsOnOneFloorGetTheMiddleOfTheirHeight) {
  // All ranges 2 cm too long, so that two heights fit better than the floor: neither is the answer.
  test::Meeting m;
  m.height_m = 0;
  m.truth.t_m.z() = 0;
  double open = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    auto made = test::meet(m, seed);
    for (MutualRange& r : made.ranges) {
      const Vec3 b = m.truth * r.p_B;
      const double before = (r.p_A - b).norm();
      r.p_A.z() = 0;
      r.range_m += (r.p_A - Vec3(b.x(), b.y(), 0)).norm() - before + 0.02;
      r.p_B.z() = 0;
    }
    const TransformAnswer answer = findTransform(made.ranges, {}, test::plainTransformOptions());
    if (answer.status != TransformStatus::unique) continue;
    const double sigma = std::sqrt(answer.solutions[0].covariance(3, 3));
    if (sigma > 0.2) {
      open += 1;
      EXPECT_LT(std::abs(answer.solutions[0].T_A_B.t_m.z()), 0.35 * sigma) << seed;
    }
  }
  EXPECT_GE(open, 6);
}

TEST(FindTransform, PlanarRobotsAreSolvedInTheirPlane) {
  test::Meeting m;
  m.height_m = 0;
  m.truth.t_m.z() = 0;
  int unique = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    auto made = test::meet(m, seed);
    for (MutualRange& r : made.ranges) {
      const Vec3 b = m.truth * r.p_B;
      r.p_A.z() = 0;
      const double before = (r.p_A - b).norm();
      const Vec3 flat(b.x(), b.y(), 0);
      r.range_m += (r.p_A - flat).norm() - before;
      r.p_B.z() = 0;
    }
    const TransformAnswer answer = findTransform(made.ranges, {}, test::plainTransformOptions());
    unique += answer.status == TransformStatus::unique;
    const auto e = errorOf(answer.solutions[0].T_A_B, m.truth);
    if (answer.status == TransformStatus::unique) {
      EXPECT_LT(e.head<3>().norm(), 0.2) << seed;
      EXPECT_GT(std::sqrt(answer.solutions[0].covariance(3, 3)), 0.3 * std::abs(e[3]));
    }
  }
  EXPECT_GE(unique, 25);
}

/// Both robots level, B's floor `height_m` above A's.
test::MadeMeeting onTwoFloors(test::Meeting m, double height_m, std::uint64_t seed) {
  m.height_m = 0;
  m.truth.t_m.z() = height_m;
  auto made = test::meet(m, seed);
  for (MutualRange& r : made.ranges) {
    const double before = (r.p_A - m.truth * r.p_B).norm();
    r.p_A.z() = r.p_B.z() = 0;
    r.range_m += (r.p_A - m.truth * r.p_B).norm() - before;
  }
  return made;
}

TEST(FindTransform, RobotsOnTwoFloorsAreTiedTogetherInAllButTheHeight) {
  const double height_m = 0.8;
  int unique = 0, open = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    test::Meeting m;
    const auto made = onTwoFloors(m, height_m, seed);
    m.truth.t_m.z() = height_m;
    const TransformAnswer answer = findTransform(made.ranges, {}, test::plainTransformOptions());
    if (answer.status != TransformStatus::unique) continue;
    ++unique;
    open += answer.height_open;
    ASSERT_EQ(answer.solutions.size(), 1u);
    const auto e = errorOf(answer.solutions[0].T_A_B, m.truth);
    EXPECT_LT(e.head<3>().norm(), 0.2) << seed;
    EXPECT_LT(std::abs(e[3]), 2.2 * std::sqrt(answer.solutions[0].covariance(3, 3))) << seed;
    EXPECT_LT(std::abs(-2 * height_m - e[3]), 3.2 * std::sqrt(answer.solutions[0].covariance(3, 3)))
        << "the other floor is covered as well, " << seed;
  }
  EXPECT_GE(unique, 27);
  EXPECT_GE(open, unique - 4);  // 2 are not with one compiler, 3 with another
}

/// Each robot's estimate of the common anchor is on a side of the floor that its ranges do not
/// tell.
TEST(FindTransform, TheSideOfTheFloorThatAnAnchorSeemsToBeOnLiftsNoWorld) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    test::Meeting m;
    auto made = onTwoFloors(m, 0, seed);
    m.truth.t_m.z() = 0;
    SharedAnchor& anchor = made.anchors[0];
    anchor.p_A.z() = 0.6;
    anchor.p_B.z() = -0.5;
    for (Mat3* C : {&anchor.cov_A, &anchor.cov_B}) {
      *C = Vec3(0.0025, 0.0025, 0.36).asDiagonal();
      (*C)(0, 2) = (*C)(2, 0) = 0.02;
    }
    const TransformAnswer answer =
        findTransform(made.ranges, made.anchors, test::plainTransformOptions());
    ASSERT_EQ(answer.status, TransformStatus::unique) << seed << " " << answer.reason;
    EXPECT_EQ(answer.solutions[0].anchors_used, 1) << seed;
    const auto e = errorOf(answer.solutions[0].T_A_B, m.truth);
    EXPECT_LT(std::abs(e[3]), 0.05) << seed;
    EXPECT_LT(e.head<3>().norm(), 0.15) << seed;
  }
}

/// One that is known to a few centimetres, or far off the floor, does.
TEST(FindTransform, AnAnchorOfKnownHeightLiftsTheWorldOfLevelRobots) {
  test::Meeting m;
  auto made = onTwoFloors(m, 0.8, 4);
  m.truth.t_m.z() = 0.8;
  const TransformAnswer answer =
      findTransform(made.ranges, made.anchors, test::plainTransformOptions());
  ASSERT_EQ(answer.status, TransformStatus::unique) << answer.reason;
  EXPECT_FALSE(answer.height_open);
  EXPECT_NEAR(answer.solutions[0].T_A_B.t_m.z(), 0.8, 0.2);
}

}  // namespace
}  // namespace vir::team
