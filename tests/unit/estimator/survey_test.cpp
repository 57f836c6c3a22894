/// Anchors with surveyed positions, through the odometry estimator.
#include <gtest/gtest.h>

#include <cmath>

#include "odometry_range_driver.h"

namespace vir::estimator {
namespace {

using vir_test::ate;
using vir_test::drifting;
using vir_test::flightOf;
using vir_test::fly;
using vir_test::RangeRun;
using vir_test::rangesTo;
using vir_test::RangeWorld;

const std::vector<Vec3> kAnchors{{9, 7, 2.5}, {-8, 6, 1.2}, {-7, -8, 3.0}, {8, -7, 0.6}};
/// Of the survey's frame in the motion's.
const LevelTransform kT_S_M{2.4, Vec3(40, 15, 3)};

RangeWorld worldOf(int seed, double length_m = 60) {
  return RangeWorld(simulation::flight("eight", flightOf(length_m, seed)), drifting(seed),
                    rangesTo(kAnchors, seed));
}

OdometryRangeConfig surveyed(double sigma_m = 0.02) {
  OdometryRangeConfig config;
  for (std::size_t i = 0; i < kAnchors.size(); ++i) {
    config.ranges.survey.push_back({i, kT_S_M * kAnchors[i], sigma_m});
  }
  return config;
}

/// RMS distance of the causal path, in the survey's frame as known at the end, from the truth [m].
double errorInSurvey(const RangeWorld& world, const RangeRun& run) {
  double sum = 0;
  for (const StateEstimate& e : run.estimates) {
    const Vec3 truth = kT_S_M * world.motion.poseAt(e.state.t).p;
    sum += (run.survey->T_S_W * e.state.T_W_B.p - truth).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(run.estimates.size()));
}

TEST(Survey, ThePathComesOutInItsFrameAndBetter) {
  double with_sum = 0, without_sum = 0, nees = 0;
  for (int seed = 1; seed <= 4; ++seed) {
    const RangeWorld world = worldOf(seed);
    const RangeRun with = fly(world, surveyed()), without = fly(world);
    EXPECT_FALSE(without.survey);
    ASSERT_TRUE(with.survey);
    ASSERT_EQ(with.survey->status, SurveyStatus::found) << with.survey->reason;
    EXPECT_TRUE(with.survey->open.empty());
    EXPECT_TRUE(with.survey->findings.empty()) << with.survey->findings.front();
    EXPECT_LT(errorInSurvey(world, with), 0.25) << seed;
    const LevelTransform T_S_W =
        kT_S_M * LevelTransform{yawOf(world.T_W_M.R()), world.T_W_M.p}.inverse();
    Eigen::Vector4d d;
    d << std::remainder(with.survey->T_S_W.yaw_rad - T_S_W.yaw_rad, 2 * M_PI),
        with.survey->T_S_W.t_m - T_S_W.t_m;
    nees += d.dot(with.survey->covariance.inverse() * d) / 4;
    for (const SurveyedResult& a : with.survey->anchors) {
      EXPECT_TRUE(a.heard && a.used);
      ASSERT_TRUE(a.p_S);
      EXPECT_LT((*a.p_S - a.given.p_S).norm(), 0.1);
    }
    EXPECT_LT(with.count(RangeDecision::collected), 1.2 * without.count(RangeDecision::collected));
    with_sum += ate(world, with);
    without_sum += ate(world, without);
  }
  EXPECT_LT(with_sum, 0.9 * without_sum);
  EXPECT_LT(nees / 4, 5);
}

TEST(Survey, TheSameTwice) {
  const RangeWorld world = worldOf(2, 30);
  const RangeRun a = fly(world, surveyed()), b = fly(world, surveyed());
  ASSERT_EQ(a.estimates.size(), b.estimates.size());
  EXPECT_EQ(a.estimates.back().state.T_W_B.p, b.estimates.back().state.T_W_B.p);
  EXPECT_EQ(a.survey->T_S_W.t_m, b.survey->T_S_W.t_m);
}

TEST(Survey, AnAnchorTwoMetresOffIsToldAndDoesNoHarm) {
  for (int seed = 1; seed <= 3; ++seed) {
    const RangeWorld world = worldOf(seed);
    OdometryRangeConfig config = surveyed();
    config.ranges.survey[1].p_S += Vec3(1.2, -1.6, 0);
    const RangeRun run = fly(world, config);
    ASSERT_TRUE(run.survey);
    ASSERT_EQ(run.survey->status, SurveyStatus::found) << run.survey->reason;
    ASSERT_EQ(run.survey->findings.size(), 1u);
    EXPECT_NE(run.survey->findings[0].find("anchor 1 "), std::string::npos)
        << run.survey->findings[0];
    EXPECT_FALSE(run.survey->anchors[1].used);
    EXPECT_LT(errorInSurvey(world, run), 0.4) << seed;
    ASSERT_TRUE(run.anchor(1) && run.anchor(1)->has_position);
    EXPECT_LT((run.anchor(1)->p_W - world.anchor(1)).norm(), 0.6) << seed;
  }
}

TEST(Survey, ExchangedIdsAreTold) {
  for (int seed = 1; seed <= 3; ++seed) {
    const RangeWorld world = worldOf(seed);
    OdometryRangeConfig config = surveyed();
    std::swap(config.ranges.survey[0].p_S, config.ranges.survey[2].p_S);
    const RangeRun run = fly(world, config);
    ASSERT_EQ(run.survey->status, SurveyStatus::found) << run.survey->reason;
    ASSERT_EQ(run.survey->findings.size(), 1u);
    EXPECT_NE(run.survey->findings[0].find("0 and 2 exchanged"), std::string::npos)
        << run.survey->findings[0];
    EXPECT_LT(errorInSurvey(world, run), 0.3) << seed;
  }
}

TEST(Survey, OtherIdsThanThoseHeardAreTold) {
  const RangeWorld world = worldOf(1, 30);
  OdometryRangeConfig config = surveyed();
  for (SurveyedAnchor& a : config.ranges.survey) a.id += 100;
  const RangeRun run = fly(world, config);
  EXPECT_EQ(run.survey->status, SurveyStatus::waiting);
  EXPECT_NE(run.survey->reason.find("none of its ids (100, 101, 102, 103)"), std::string::npos)
      << run.survey->reason;
  config = surveyed();
  config.ranges.survey.pop_back();
  config.ranges.survey.push_back({55, Vec3(1, 2, 3), 0.02});
  const RangeRun some = fly(world, config);
  EXPECT_EQ(some.survey->status, SurveyStatus::found) << some.survey->reason;
  ASSERT_EQ(some.survey->findings.size(), 2u);
  EXPECT_NE(some.survey->findings[0].find("never heard: 55"), std::string::npos);
  EXPECT_NE(some.survey->findings[1].find("not in the survey: 3"), std::string::npos);
}

TEST(Survey, OneAnchorLeavesTheTurnOpen) {
  const RangeWorld world(simulation::flight("eight", flightOf(40)), drifting(),
                         rangesTo({kAnchors[0]}));
  OdometryRangeConfig config;
  config.ranges.survey.push_back({0, kT_S_M * kAnchors[0], 0.02});
  const RangeRun run = fly(world, config);
  EXPECT_NE(run.survey->status, SurveyStatus::found);
  EXPECT_EQ(run.survey->open, (std::vector<std::string>{"yaw", "x", "y"}));
  // And changes nothing of what is estimated without.
  const RangeRun without = fly(world);
  EXPECT_EQ(run.estimates.back().state.T_W_B.p, without.estimates.back().state.T_W_B.p);
}

TEST(Survey, AnAnchorThatIsMovedLeavesIt) {
  simulation::RangeSimulationOptions ranges = rangesTo(kAnchors);
  ranges.jump = {2, 35, -3, -9, 2};
  const RangeWorld world(simulation::flight("eight", flightOf(120)), drifting(), ranges);
  const RangeRun run = fly(world, surveyed());
  ASSERT_EQ(run.survey->status, SurveyStatus::found) << run.survey->reason;
  EXPECT_FALSE(run.survey->anchors[2].used);
  ASSERT_EQ(run.survey->findings.size(), 1u);
  EXPECT_NE(run.survey->findings[0].find("anchor 2 is at"), std::string::npos)
      << run.survey->findings[0];
  EXPECT_LT(errorInSurvey(world, run), 0.4);
}

TEST(Survey, AnAnchorHeardLateIsPlacedAtOnce) {
  const RangeWorld world = worldOf(1, 80);
  std::vector<Range> ranges;
  for (const Range& r : world.ranges) {
    if (r.anchor != 3 || r.t > world.time(30)) ranges.push_back(r);
  }
  const RangeRun run = fly(world, surveyed(), ranges);
  ASSERT_EQ(run.survey->status, SurveyStatus::found) << run.survey->reason;
  EXPECT_TRUE(run.survey->anchors[3].used);
  long collected = 0;
  for (const RangeRecord& d : run.decisions) {
    collected += d.anchor == 3 && d.decision == RangeDecision::collected;
  }
  EXPECT_LT(collected, 12) << "about a keyframe's worth";
}

}  // namespace
}  // namespace vir::estimator
