/// What ties anchors to one another: a survey whose place nobody knows, and ranges between them.
#include <gtest/gtest.h>

#include "long_window_world.h"
#include "vir/ranging/robust_range.h"

namespace vir::window {
namespace {

using vir_test::Walk;
using vir_test::WalkOptions;

WalkOptions threeAnchors() {
  WalkOptions o;
  o.nodes = 25;
  o.anchors = {{8, 5, 3}, {-9, 4, 1}, {1, -8, 2}};
  return o;
}

const LevelTransform kT_S_W{0.8, Vec3(30, -12, 1)};

std::vector<SurveyTie> surveyOf(const WalkOptions& o, double sigma_m) {
  std::vector<SurveyTie> out;
  for (std::size_t a = 0; a < o.anchors.size(); ++a) {
    out.push_back({a, kT_S_W * o.anchors[a], sigma_m * (1 + 0.5 * static_cast<double>(a))});
  }
  return out;
}

/// Head and anchors as in eliminate(); position of anchor `a`, coordinate `i`.
int columnOf(std::size_t a, int i) { return 5 + 4 * static_cast<int>(a) + i; }

/// Twice the loss of a survey and distances, with the anchors at these places.
double costOf(const std::vector<Vec3>& p, const std::vector<SurveyTie>& survey,
              const std::vector<AnchorDistance>& distances) {
  std::vector<LevelPair> pairs;
  for (const SurveyTie& t : survey) {
    pairs.push_back({t.p_S, p[t.anchor], 1 / (t.sigma_m * t.sigma_m)});
  }
  double sum = fitLevel(pairs).cost;
  for (const AnchorDistance& d : distances) {
    const double r = (d.range_m - (p[d.first] - p[d.second]).norm()) / d.sigma_m;
    sum += 2 * ranging::RobustRange().loss(r);
  }
  return sum;
}

/// What the ties add to the equations agrees with numeric derivatives of their loss.
void checkAgainstNumeric(const std::vector<SurveyTie>& survey,
                         const std::vector<AnchorDistance>& distances, double offset_m,
                         bool hessian) {
  const Walk walk(threeAnchors());
  LongWindow w{LongWindowOptions()};
  walk.start(&w);
  walk.addAnchors(&w, offset_m, 10);
  for (std::size_t k = 1; k < walk.truth.size(); ++k) walk.advance(&w, k);
  std::vector<Vec3> p;
  for (std::size_t a = 0; a < 3; ++a) {
    w.anchor(a)->x[0] += 0.1 * offset_m * static_cast<double>(a);  // not all alike
    p.push_back(w.anchor(a)->position());
  }
  const NormalEquations without = w.eliminate();
  w.setSurvey(survey);
  w.setAnchorDistances(distances);
  const NormalEquations with = w.eliminate();
  const Eigen::VectorXd b = with.b - without.b;
  const Eigen::MatrixXd H = with.H - without.H;
  EXPECT_LT(b.head<5>().norm(), 1e-6 * (1 + b.norm())) << "the head is not touched";
  const double h = 1e-4;
  const auto cost = [&](std::size_t a, int i, double da, std::size_t c, int j, double dc) {
    std::vector<Vec3> q = p;
    q[a][i] += da;
    q[c][j] += dc;
    return costOf(q, survey, distances);
  };
  for (std::size_t a = 0; a < 3; ++a) {
    for (int i = 0; i < 3; ++i) {
      const double slope = (cost(a, i, h, a, i, 0) - cost(a, i, -h, a, i, 0)) / (4 * h);
      EXPECT_NEAR(b[columnOf(a, i)], slope, 1e-3 * (1 + std::abs(slope))) << a << i;
      for (std::size_t c = 0; hessian && c < 3; ++c) {
        for (int j = 0; j < 3; ++j) {
          const double bend = (cost(a, i, h, c, j, h) - cost(a, i, h, c, j, -h) -
                               cost(a, i, -h, c, j, h) + cost(a, i, -h, c, j, -h)) /
                              (8 * h * h);
          EXPECT_NEAR(H(columnOf(a, i), columnOf(c, j)), bend, 0.02 * H.diagonal().maxCoeff())
              << a << i << c << j;
        }
      }
    }
  }
}

TEST(AnchorTies, ASurveyAddsWhatItsLossSays) {
  checkAgainstNumeric(surveyOf(threeAnchors(), 0.1), {}, 0, true);
  checkAgainstNumeric(surveyOf(threeAnchors(), 0.1), {}, 0.4, false);
}

TEST(AnchorTies, TwoAnchorsOfASurveyAddTheirDistanceAndHeights) {
  std::vector<SurveyTie> survey = surveyOf(threeAnchors(), 0.1);
  survey.pop_back();
  checkAgainstNumeric(survey, {}, 0, true);
}

TEST(AnchorTies, DistancesAddWhatTheirLossSays) {
  const std::vector<Vec3> p = threeAnchors().anchors;
  const std::vector<AnchorDistance> distances{{0, 1, (p[0] - p[1]).norm(), 0.1},
                                              {2, 0, (p[0] - p[2]).norm(), 0.2}};
  checkAgainstNumeric({}, distances, 0, true);
  checkAgainstNumeric({}, distances, 0.4, false);
}

TEST(AnchorTies, WhatIsNoPairOfAnchorsAddsNothing) {
  const Walk walk(threeAnchors());
  LongWindow w{LongWindowOptions()};
  walk.start(&w);
  walk.addAnchors(&w, 0.2, 0.5);
  for (std::size_t k = 1; k < walk.truth.size(); ++k) walk.advance(&w, k);
  const NormalEquations without = w.eliminate();
  w.setSurvey({surveyOf(threeAnchors(), 0.1).front()});
  w.setAnchorDistances({{0, 7, 3.0, 0.1}, {1, 1, 3.0, 0.1}});
  const NormalEquations with = w.eliminate();
  EXPECT_LT((with.H - without.H).norm(), 1e-9 * without.H.norm());
  EXPECT_LT((with.b - without.b).norm(), 1e-9 * (1 + without.b.norm()));
}

/// RMS error of the anchors, solved from 0.3 m off.
double errorWith(const std::vector<SurveyTie>& survey,
                 const std::vector<AnchorDistance>& distances) {
  WalkOptions o = threeAnchors();
  o.nodes = 30;
  o.range_noise_m = 0.2;
  double sum = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    o.seed = seed;
    const Walk walk(o);
    LongWindow w{LongWindowOptions()};
    walk.start(&w);
    walk.addAnchors(&w, 0.3, 3);
    for (std::size_t k = 1; k < walk.truth.size(); ++k) walk.advance(&w, k);
    w.setSurvey(survey);
    w.setAnchorDistances(distances);
    EXPECT_TRUE(w.solve(20, walk.lastRanges()));
    for (std::size_t a = 0; a < 3; ++a)
      sum += (w.anchor(a)->position() - o.anchors[a]).squaredNorm();
    if (survey.empty()) continue;
    const LevelFit fit = w.surveyFit();
    EXPECT_NEAR(fit.T_A_B.yaw_rad, kT_S_W.yaw_rad, 0.05);
    EXPECT_LT((fit.T_A_B * o.anchors[0] - kT_S_W * o.anchors[0]).norm(), 0.6);
  }
  return std::sqrt(sum / 15);
}

TEST(AnchorTies, TheyMakeAnchorsBetter) {
  const WalkOptions o = threeAnchors();
  std::vector<AnchorDistance> distances;
  for (std::uint64_t a = 0; a < 3; ++a) {
    const std::uint64_t b = (a + 1) % 3;
    distances.push_back({a, b, (o.anchors[a] - o.anchors[b]).norm(), 0.05});
  }
  const double alone = errorWith({}, {});
  EXPECT_LT(errorWith({}, distances), 0.9 * alone);
  EXPECT_LT(errorWith(surveyOf(o, 0.02), {}), 0.6 * alone);
}

}  // namespace
}  // namespace vir::window
