#include "vir/ranging/survey_match.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "vir_test_noise.h"

namespace vir::ranging {
namespace {

const LevelTransform kT_S_W{1.9, Vec3(21, -7, 1.2)};

struct Hall {
  std::vector<Vec3> anchors{{0, 0, 2.5}, {12, 0, 3.0}, {12, 9, 2.2}, {0, 9, 2.8}};  ///< truly, in S
  Vec3 amplitude = Vec3(2, 1.5, 0.5);  ///< of the path about the hall's middle [m]
  double sigma = 0.05, seconds = 15;
  std::vector<double> bias;  ///< per anchor; empty: none
  double nlos = 0;           ///< share of ranges lengthened by 0.3 to 1.8 m
  std::uint64_t seed = 1;
};

std::vector<SurveyRange> flyThrough(const Hall& hall) {
  test::Noise noise(hall.seed);
  std::vector<SurveyRange> out;
  const LevelTransform T_W_S = kT_S_W.inverse();
  for (double t = 0; t < hall.seconds; t += 0.05) {
    const Vec3 p_S = Vec3(6, 4.5, 1.2) + Vec3(hall.amplitude.x() * std::sin(0.5 * t),
                                              hall.amplitude.y() * std::sin(0.7 * t + 0.3),
                                              hall.amplitude.z() * std::sin(0.9 * t + 1));
    const std::size_t a = out.size() % hall.anchors.size();
    double range = (p_S - hall.anchors[a]).norm() + hall.sigma * noise.normal();
    if (!hall.bias.empty()) range += hall.bias[a];
    if (hall.nlos > 0 && noise.uniform() < hall.nlos) range += 0.3 + 1.5 * noise.uniform();
    out.push_back({a, T_W_S * p_S, range, hall.sigma});
  }
  return out;
}

std::vector<SurveyedAnchor> surveyOf(const std::vector<Vec3>& anchors, double sigma_m = 0.02) {
  std::vector<SurveyedAnchor> out;
  for (const Vec3& p : anchors) out.push_back({out.size() + 10, p, sigma_m});
  return out;
}

SurveyMatchOptions boards() {
  SurveyMatchOptions o;
  o.bias_sigma_m = 0.03;
  o.uncalibrated_bias_sigma_m = 0.7;
  o.drift_ratio = 0.002;
  return o;
}

double errorOf(const LevelTransform& T_S_W) {
  double worst = 0;
  for (const Vec3& p_S : Hall().anchors) {
    worst = std::max(worst, (T_S_W * (kT_S_W.inverse() * p_S) - p_S).norm());
  }
  return worst;
}

/// (yaw, t) off by how many sigmas, squared.
double mahalanobis(const SurveyMatch& m) {
  Eigen::Vector4d d;
  d << std::remainder(m.T_S_W.yaw_rad - kT_S_W.yaw_rad, 2 * M_PI), m.T_S_W.t_m - kT_S_W.t_m;
  return d.dot(m.covariance.inverse() * d);
}

TEST(SurveyMatch, FindsHowTheSurveyLies) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Hall hall;
    hall.seed = seed;
    const SurveyMatch m = matchSurvey(flyThrough(hall), surveyOf(hall.anchors), boards());
    ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
    EXPECT_LT(errorOf(m.T_S_W), 0.15) << seed;
    EXPECT_TRUE(m.findings.empty());
    EXPECT_FALSE(m.uncalibrated);
    EXPECT_FALSE(m.other);
    sum += mahalanobis(m);
    for (std::size_t a = 0; a < 4; ++a) {
      EXPECT_LT((m.anchors[a].p_W - kT_S_W.inverse() * hall.anchors[a]).norm(), 0.15);
    }
  }
  // Four numbers: the mean of ten is 4 +- 0.9.
  EXPECT_GT(sum / 10, 1.0);
  EXPECT_LT(sum / 10, 8.0);
}

TEST(SurveyMatch, FindsItFromAStretchThatTellsNoAnchorByItself) {
  Hall hall;
  hall.amplitude = Vec3(0.5, 0.4, 0.1);
  const std::vector<SurveyRange> ranges = flyThrough(hall);
  const SurveyMatch m = matchSurvey(ranges, surveyOf(hall.anchors), boards());
  ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
  EXPECT_LT(errorOf(m.T_S_W), 0.5);
}

TEST(SurveyMatch, BoardsAsTheyComeAndHiddenAnchors) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Hall hall;
    hall.seed = seed;
    hall.bias = {0.5, 0.62, 0.45, 0.55};
    hall.nlos = 0.2;
    const SurveyMatch m = matchSurvey(flyThrough(hall), surveyOf(hall.anchors), boards());
    ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
    EXPECT_TRUE(m.uncalibrated);
    EXPECT_TRUE(m.findings.empty());
    EXPECT_LT(errorOf(m.T_S_W), 0.25) << seed;
    for (std::size_t a = 0; a < 4; ++a) EXPECT_NEAR(m.anchors[a].bias_m, hall.bias[a], 0.2);
  }
}

TEST(SurveyMatch, ExchangedIdsAreNamed) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Hall hall;
    hall.seed = seed;
    std::vector<SurveyedAnchor> survey = surveyOf(hall.anchors);
    std::swap(survey[1].p_S, survey[2].p_S);
    const SurveyMatch m = matchSurvey(flyThrough(hall), survey, boards());
    ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
    ASSERT_EQ(m.findings.size(), 1u);
    EXPECT_EQ(m.findings[0].fault, SurveyFault::exchanged);
    EXPECT_EQ(m.findings[0].first + m.findings[0].second, 3u);
    EXPECT_LT(errorOf(m.T_S_W), 0.15);
    const std::string said = describe(m.findings[0], survey);
    EXPECT_NE(said.find("11 and 12 exchanged"), std::string::npos) << said;
  }
}

TEST(SurveyMatch, AnAnchorTwoMetresOffIsLeftOutAndFound) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Hall hall;
    hall.seed = seed;
    hall.amplitude = Vec3(3, 2.5, 0.8);
    std::vector<SurveyedAnchor> survey = surveyOf(hall.anchors);
    survey[3].p_S += Vec3(1.6, -1.2, 0);
    const SurveyMatch m = matchSurvey(flyThrough(hall), survey, boards());
    ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
    ASSERT_EQ(m.findings.size(), 1u);
    EXPECT_EQ(m.findings[0].fault, SurveyFault::elsewhere);
    EXPECT_EQ(m.findings[0].first, 3u);
    EXPECT_FALSE(m.anchors[3].used);
    EXPECT_TRUE(m.anchors[0].used);
    EXPECT_LT(errorOf(m.T_S_W), 0.2);
    ASSERT_TRUE(m.findings[0].found_S);
    EXPECT_LT((*m.findings[0].found_S - hall.anchors[3]).norm(), 0.4);
  }
}

TEST(SurveyMatch, MillimetresAreToldFromMetres) {
  const Hall hall;
  std::vector<SurveyedAnchor> survey = surveyOf(hall.anchors);
  for (SurveyedAnchor& a : survey) a.p_S *= 1000;
  const SurveyMatch m = matchSurvey(flyThrough(hall), survey, boards());
  ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
  ASSERT_EQ(m.findings.size(), 1u);
  EXPECT_EQ(m.findings[0].fault, SurveyFault::unit);
  EXPECT_EQ(m.findings[0].factor, 0.001);
  EXPECT_LT(errorOf(m.T_S_W), 0.15);
}

TEST(SurveyMatch, ASurveyOfAnotherHallIsContradictedOrOpenNeverFound) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Hall hall;
    hall.seed = seed;
    const std::vector<SurveyedAnchor> survey =
        surveyOf({{30, 2, 1}, {3, 40, 3}, {-20, 9, 7}, {5, -33, 2.8}});
    const SurveyMatch m = matchSurvey(flyThrough(hall), survey, boards());
    EXPECT_NE(m.status, SurveyStatus::found);
    EXPECT_FALSE(m.reason.empty());
  }
}

TEST(SurveyMatch, OnALevelPathTheHeightStaysOpen) {
  Hall hall;
  for (Vec3& a : hall.anchors) a.z() = 2.7;
  hall.amplitude = Vec3(3, 2.5, 0);
  const SurveyMatch m = matchSurvey(flyThrough(hall), surveyOf(hall.anchors), boards());
  ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
  ASSERT_TRUE(m.other);
  EXPECT_NEAR(std::abs(m.other->t_m.z() - m.T_S_W.t_m.z()), 3.0, 0.3);
  EXPECT_LT((m.T_S_W.t_m - kT_S_W.t_m).head<2>().norm(), 0.3);
}

TEST(SurveyMatch, TwoAnchorsDo) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Hall hall;
    hall.seed = seed;
    hall.anchors.resize(2);
    hall.amplitude = Vec3(3, 2.5, 0.8);
    const SurveyMatch m = matchSurvey(flyThrough(hall), surveyOf(hall.anchors), boards());
    ASSERT_EQ(m.status, SurveyStatus::found) << m.reason;
    EXPECT_LT(errorOf(m.T_S_W), 0.4) << seed;
  }
}

TEST(SurveyMatch, TooLittleIsSaid) {
  Hall hall;
  hall.anchors.resize(1);
  SurveyMatch m = matchSurvey(flyThrough(hall), surveyOf(hall.anchors), boards());
  EXPECT_EQ(m.status, SurveyStatus::waiting);
  EXPECT_FALSE(m.reason.empty());
  hall = Hall();
  hall.amplitude.setZero();
  m = matchSurvey(flyThrough(hall), surveyOf(hall.anchors), boards());
  EXPECT_EQ(m.status, SurveyStatus::open) << "standing: nothing tells the turn";
  hall = Hall();
  hall.seconds = 0.5;
  m = matchSurvey(flyThrough(hall), surveyOf(hall.anchors), boards());
  EXPECT_EQ(m.status, SurveyStatus::waiting);
}

TEST(SurveyMatch, WhateverComesTheNumbersStayFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Hall hall;
  std::vector<SurveyRange> ranges = flyThrough(hall);
  ranges[0].range_m = nan;
  ranges[1].p_W.x() = nan;
  ranges[2].sigma_m = 0;
  ranges[3].anchor = 99;
  ranges[4].range_m = -3;
  const SurveyMatch m = matchSurvey(ranges, surveyOf(hall.anchors), boards());
  EXPECT_EQ(m.status, SurveyStatus::found) << m.reason;
  const SurveyMatch same = matchSurvey(
      ranges, surveyOf({Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}), boards());
  EXPECT_NE(same.status, SurveyStatus::found);
  EXPECT_TRUE(same.covariance.allFinite());
  EXPECT_TRUE(matchSurvey({}, {}, boards()).anchors.empty());
}

}  // namespace
}  // namespace vir::ranging
