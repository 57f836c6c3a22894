#include "vir/ranging/survey_differences.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "vir/core/angles.h"
#include "vir_test_noise.h"

namespace vir::ranging {
namespace {

const LevelTransform kT_S_W{1.9, Vec3(21, -7, 1.2)};

std::vector<SurveyedAnchor> hall() {
  return {{10, {0, 0, 2.5}, 0.02},
          {11, {12, 0, 3.0}, 0.02},
          {12, {12, 9, 0.4}, 0.02},
          {13, {0, 9, 2.8}, 0.02}};
}

struct Flight {
  double sigma = 0, seconds = 15, outliers = 0;
  std::size_t heard = 4;  ///< anchors
  std::uint64_t seed = 1;
};

std::vector<SurveyDifference> flyThrough(const Flight& f) {
  test::Noise noise(f.seed);
  std::vector<SurveyDifference> out;
  const LevelTransform T_W_S = kT_S_W.inverse();
  const auto survey = hall();
  for (double t = 0; t < f.seconds; t += 0.05) {
    const Vec3 p_S = Vec3(6, 4.5, 1.2) + Vec3(2 * std::sin(0.5 * t), 1.5 * std::sin(0.7 * t + 0.3),
                                              0.5 * std::sin(0.9 * t + 1));
    const std::size_t a = out.size() % f.heard, reference = (a + f.heard - 1) % f.heard;
    double d = (p_S - survey[a].p_S).norm() - (p_S - survey[reference].p_S).norm();
    d += f.sigma * noise.normal();
    if (noise.uniform() < f.outliers) d += noise.uniform() < 0.5 ? 1.3 : -1.3;
    out.push_back({a, reference, T_W_S * p_S, d, std::max(f.sigma, 0.01)});
  }
  return out;
}

void expectPlace(const SurveyMatch& match, double m, double rad) {
  ASSERT_EQ(match.status, SurveyStatus::found) << match.reason;
  EXPECT_NEAR(std::remainder(match.T_S_W.yaw_rad - kT_S_W.yaw_rad, 2 * kPi), 0, rad);
  const LevelTransform T_W_S = kT_S_W.inverse();
  for (std::size_t i = 0; i < match.anchors.size(); ++i) {
    EXPECT_TRUE(match.anchors[i].used);
    EXPECT_LT((match.anchors[i].p_W - T_W_S * match.survey[i].p_S).norm(), m) << i;
  }
}

TEST(SurveyDifferences, ExactOnesGiveTheExactPlace) {
  SurveyMatchOptions o;
  o.drift_ratio = 0;
  expectPlace(matchSurveyByDifferences(flyThrough({}), hall(), o), 1e-3, 1e-4);
}

TEST(SurveyDifferences, NoiseAndOutliersOfBothSigns) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Flight f;
    f.sigma = 0.07;
    f.outliers = 0.15;
    f.seed = seed;
    const SurveyMatch match = matchSurveyByDifferences(flyThrough(f), hall(), {});
    expectPlace(match, 0.35, 0.06);
    for (const MatchedAnchor& a : match.anchors) {
      EXPECT_GT(a.covariance(0, 0), 0);
      EXPECT_LT((a.covariance.topLeftCorner<3, 3>().trace()), 0.5);
    }
  }
}

TEST(SurveyDifferences, TwoAnchorsOrHardlyAnyMotionDoNotTell) {
  Flight two;
  two.heard = 2;
  SurveyMatch match = matchSurveyByDifferences(flyThrough(two), hall(), {});
  EXPECT_EQ(match.status, SurveyStatus::waiting);
  EXPECT_NE(match.reason.find("three of its anchors"), std::string::npos) << match.reason;
  Flight standing;
  standing.sigma = 0.07;
  auto list = flyThrough(standing);
  for (SurveyDifference& d : list) d.p_W = list.front().p_W;
  match = matchSurveyByDifferences(list, hall(), {});
  EXPECT_NE(match.status, SurveyStatus::found);
  EXPECT_FALSE(match.reason.empty());
}

TEST(SurveyDifferences, ASurveyThatFitsNothingIsContradicted) {
  Flight f;
  f.sigma = 0.07;
  auto list = flyThrough(f);
  for (SurveyDifference& d : list) d.difference_m *= 1000;  // millimetres
  const SurveyMatch match = matchSurveyByDifferences(list, hall(), {});
  EXPECT_EQ(match.status, SurveyStatus::contradicted);
  EXPECT_NE(match.reason.find("metres"), std::string::npos) << match.reason;
}

TEST(SurveyDifferences, NonsenseIsLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SurveyMatchOptions o;
  o.drift_ratio = 0;
  auto list = flyThrough({});
  list.push_back({99, 0, Vec3::Zero(), 1, 0.1});
  list.push_back({1, 1, Vec3::Zero(), 0, 0.1});
  list.push_back({1, 2, Vec3(nan, 0, 0), 1, 0.1});
  list.push_back({1, 2, Vec3::Zero(), nan, 0.1});
  list.push_back({1, 2, Vec3::Zero(), 1, 0});
  expectPlace(matchSurveyByDifferences(list, hall(), o), 1e-3, 1e-4);
  EXPECT_EQ(matchSurveyByDifferences({}, hall(), {}).status, SurveyStatus::waiting);
  EXPECT_EQ(matchSurveyByDifferences(list, {}, {}).status, SurveyStatus::waiting);
}

}  // namespace
}  // namespace vir::ranging
