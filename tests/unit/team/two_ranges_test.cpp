/// A common anchor and two mutual ranges, the paper's case.
#include <Eigen/Dense>
//
#include <gtest/gtest.h>

#include "meetings.h"
#include "vir/team/closed_form.h"

namespace vir::team {
namespace {

struct TwoRanges {
  WorldTransform truth;
  test::MadeMeeting made;
};

/// Positions, anchor and transform at random; the robots move by metres between the two ranges.
TwoRanges draw(test::Noise* noise, double sigma, bool add_noise) {
  const auto random = [&](double metres, double height) {
    return Vec3(metres * noise->normal(), metres * noise->normal(), height * noise->normal());
  };
  TwoRanges out;
  out.truth = {2 * M_PI * (noise->uniform() - 0.5), random(5, 2)};
  SharedAnchor anchor;
  anchor.p_B = random(5, 2);
  anchor.p_A = out.truth * anchor.p_B;
  out.made.anchors.push_back(anchor);
  for (int i = 0; i < 2; ++i) {
    MutualRange r;
    r.t = fromSeconds(10 + 5 * i);
    r.p_A = random(5, 2);
    r.p_B = random(5, 2);
    r.sigma_m = sigma;
    r.range_m = (r.p_A - out.truth * r.p_B).norm() + (add_noise ? sigma * noise->normal() : 0);
    if (r.range_m <= 0) r.range_m = 1e-3;
    out.made.ranges.push_back(r);
  }
  return out;
}

/// How far from fitting the second range the first one's wrong yaw is [m], and how well the yaw is
/// determined; small: degenerate.
bool degenerate(const TwoRanges& c, double margin_m) {
  const auto& ranges = c.made.ranges;
  const auto& anchors = c.made.anchors;
  double best_slope = 0;
  for (const MutualRange& r : ranges) {
    const WorldTransform plus{c.truth.yaw_rad + 1e-4, Vec3::Zero()};
    const WorldTransform T = throughAnchor(plus.yaw_rad, anchors[0]);
    best_slope = std::max(
        best_slope, std::abs((r.p_A - T * r.p_B).norm() - (r.p_A - c.truth * r.p_B).norm()) / 1e-4);
  }
  if (best_slope < 0.1) return true;
  // The smallest misfit of any yaw that is not the truth's own basin.
  double smallest = 1e9;
  for (int i = 0; i < 2; ++i) {
    const YawPair pair = yawsFromRange(ranges[static_cast<std::size_t>(i)], anchors[0]);
    if (pair.problem != YawProblem::none) return true;
    for (const double yaw : pair.yaw_rad) {
      if (std::abs(wrapAngle(yaw - c.truth.yaw_rad)) < 1e-3) continue;
      const MutualRange& other = ranges[static_cast<std::size_t>(1 - i)];
      const WorldTransform T = throughAnchor(yaw, anchors[0]);
      smallest = std::min(smallest, std::abs((other.p_A - T * other.p_B).norm() - other.range_m));
    }
  }
  return smallest < margin_m;
}

TEST(TwoRangesAndAnchor, ExactWithoutNoise) {
  test::Noise noise(1);
  TransformOptions options = test::plainTransformOptions();
  int cases = 0, exact = 0, unique = 0;
  for (int i = 0; cases < 10000; ++i) {
    const TwoRanges c = draw(&noise, 1e-3, false);
    if (degenerate(c, 0.05)) continue;
    ++cases;
    const TransformAnswer answer = findTransform(c.made.ranges, c.made.anchors, options);
    ASSERT_FALSE(answer.solutions.empty());
    const auto error = test::errorOf(answer.solutions[0].T_A_B, c.truth);
    exact += error.norm() < 1e-6;
    unique += answer.status == TransformStatus::unique;
    if (error.norm() >= 1e-6) {
      ADD_FAILURE() << i << ": error " << error.transpose() << " " << name(answer.status);
    }
  }
  EXPECT_EQ(exact, 10000);
  EXPECT_GT(unique, 9000);
}

TEST(TwoRangesAndAnchor, AWrongOneIsHardlyEverCalledUnique) {
  test::Noise noise(2);
  const TransformOptions options = test::plainTransformOptions();
  int cases = 0, wrong = 0, unique = 0;
  for (int i = 0; cases < 10000; ++i) {
    const TwoRanges c = draw(&noise, 0.05, true);
    ++cases;
    const TransformAnswer answer = findTransform(c.made.ranges, c.made.anchors, options);
    if (answer.status != TransformStatus::unique) continue;
    ++unique;
    const auto error = test::errorOf(answer.solutions[0].T_A_B, c.truth);
    // The other candidate, not the noise of the right one.
    wrong += std::abs(error[0]) > 0.05 + 6 * std::sqrt(answer.solutions[0].covariance(0, 0));
  }
  RecordProperty("unique", unique);
  RecordProperty("wrong", wrong);
  EXPECT_LT(wrong, 10);
  EXPECT_GT(unique, 3000);
}

TEST(TwoRangesAndAnchor, OneRangeLeavesTwo) {
  test::Noise noise(3);
  int ambiguous = 0, right = 0;
  for (int i = 0; i < 200; ++i) {
    TwoRanges c = draw(&noise, 0.01, false);
    c.made.ranges.resize(1);
    const TransformAnswer answer =
        findTransform(c.made.ranges, c.made.anchors, test::plainTransformOptions());
    EXPECT_NE(answer.status, TransformStatus::unique);
    if (answer.status != TransformStatus::ambiguous) continue;
    ++ambiguous;
    // The two yaws may all but coincide: then they are one answer with a wide covariance.
    if (answer.solutions.size() == 1) {
      ++right;
      continue;
    }
    double nearest = 1e9;
    for (const auto& s : answer.solutions) {
      nearest = std::min(nearest, test::errorOf(s.T_A_B, c.truth).norm());
    }
    // Where the two yaws nearly meet, a rounding error of the range is its root in the yaw.
    right += nearest < 1e-3;
  }
  EXPECT_GT(ambiguous, 180);
  EXPECT_EQ(right, ambiguous);
}

TEST(TwoRangesAndAnchor, ARangeThatFitsNoYawIsRejected) {
  test::Noise noise(4);
  TwoRanges c = draw(&noise, 0.05, false);
  c.made.ranges[1].range_m += 60;
  const TransformAnswer answer =
      findTransform(c.made.ranges, c.made.anchors, test::plainTransformOptions());
  EXPECT_EQ(answer.status, TransformStatus::inconsistent);
}

}  // namespace
}  // namespace vir::team
