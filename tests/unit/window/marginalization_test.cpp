/// Elimination against dense linear algebra on random least-squares problems.
#include "vir/window/marginalization.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <random>

#include "vir_test_jacobian.h"

namespace vir::window {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kFrameColumns = 45;

/// Three frames (pose, speed_bias) and six landmarks tied together by random linear residuals.
class RandomProblem {
 public:
  explicit RandomProblem(unsigned seed) : random_(seed) {
    for (int f = 0; f < 3; ++f) {
      const double a = u(), b = u(), c = u();
      blocks_.push_back(vir_test::poseBlock(Pose(expQuat(Vec3(a, b, c)), Vec3(c, a, b))));
      blocks_.push_back(std::vector<double>(9));
      for (double& x : blocks_.back()) x = u();
    }
    for (int l = 0; l < 6; ++l) blocks_.push_back({u(), u(), u()});
    for (int f = 0; f < 3; ++f) link({2 * f, 2 * f + 1}, -1, 16);
    link({0, 1, 2, 3}, -1, 6);
    link({2, 3, 4, 5}, -1, 6);
    for (int l = 6; l < 12; ++l) {
      link({}, l, 2);
      for (int f = 0; f < 3; ++f) link({2 * ((l + f) % 3), 2 * ((l + f + 1) % 3)}, l, 3);
    }
  }

  std::vector<BlockRef> frames() {
    std::vector<BlockRef> out;
    for (int k = 0; k < 6; ++k) out.push_back({address(k), k % 2 ? 9 : 7, 0, nullptr});
    return out;
  }

  /// H and b of everything at the current values; landmarks come after the frames.
  void dense(MatrixXd* H, VectorXd* b) const {
    std::vector<int> offset;
    int n = 0;
    for (const auto& x : blocks_) {
      offset.push_back(n);
      n += x.size() == 7 ? 6 : static_cast<int>(x.size());
    }
    *H = MatrixXd::Zero(n, n);
    *b = VectorXd::Zero(n);
    for (std::size_t t = 0; t < terms.size(); ++t) {
      vir_test::Blocks x;
      for (int k : touched_[t]) x.push_back(blocks_[static_cast<std::size_t>(k)]);
      VectorXd r;
      const auto J = vir_test::analyticJacobians(*terms[t].cost, x, &r);
      MatrixXd row = MatrixXd::Zero(r.size(), n);
      for (std::size_t k = 0; k < x.size(); ++k) {
        const int local = x[k].size() == 7 ? 6 : static_cast<int>(x[k].size());
        row.middleCols(offset[static_cast<std::size_t>(touched_[t][k])], local) =
            J[k].leftCols(local);
      }
      *H += row.transpose() * row;
      *b += row.transpose() * r;
    }
  }

  /// The last column of every landmark's Jacobians becomes zero: nobody observes its depth.
  void blindLandmarks() {
    for (std::size_t t = 0; t < terms.size(); ++t) {
      if (terms[t].landmark) priors_[t]->J.rightCols(1).setZero();
    }
  }

  std::vector<Term> terms;

 private:
  double u() { return uniform_(random_); }
  double* address(int k) { return blocks_[static_cast<std::size_t>(k)].data(); }

  void link(std::vector<int> which, int landmark, int rows) {
    if (landmark >= 0) which.push_back(landmark);
    auto prior = std::make_unique<factors::LinearPrior>();
    int n = 0;
    Term t;
    for (int k : which) {
      const std::vector<double>& x = blocks_[static_cast<std::size_t>(k)];
      factors::LinearPrior::Block block;
      block.ambient = static_cast<int>(x.size());
      block.offset = n;
      block.x0 = x;
      n += block.local();
      if (block.ambient == 7) {
        factors::posePlus(x.data(), std::vector<double>(6, 0.1 * u()).data(), block.x0.data());
      } else {
        for (double& v : block.x0) v += 0.1 * u();
      }
      prior->blocks.push_back(block);
      t.blocks.add(address(k));
    }
    prior->J.resize(rows, n);
    prior->r0.resize(rows);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < n; ++c) prior->J(r, c) = u();
      prior->r0[r] = u();
    }
    priors_.push_back(std::move(prior));
    costs_.push_back(std::make_unique<factors::LinearPriorFactor>(*priors_.back()));
    t.cost = costs_.back().get();
    if (landmark >= 0) t.landmark = address(landmark);
    touched_.push_back(which);
    terms.push_back(t);
  }

  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
  vir_test::Blocks blocks_;
  std::vector<std::unique_ptr<factors::LinearPrior>> priors_;
  std::vector<std::unique_ptr<factors::LinearPriorFactor>> costs_;
  std::vector<std::vector<int>> touched_;
};

/// The marginal of a Gaussian: the block of its covariance and of its mean.
void denseMarginal(const MatrixXd& H, const VectorXd& b, int first, int count, MatrixXd* Hm,
                   VectorXd* bm) {
  const MatrixXd P = H.inverse();
  const VectorXd mean = -P * b;
  *Hm = P.block(first, first, count, count).inverse();
  *bm = -*Hm * mean.segment(first, count);
}

TEST(Marginalization, LandmarksAndFramesAgainstTheDenseMarginal) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    RandomProblem problem(seed);
    MatrixXd H, Hm;
    VectorXd b, bm;
    problem.dense(&H, &b);
    const NormalEquations reduced = eliminateLandmarks(problem.terms, problem.frames());
    denseMarginal(H, b, 0, kFrameColumns, &Hm, &bm);
    ASSERT_EQ(reduced.H.rows(), kFrameColumns);
    EXPECT_LT((reduced.H - Hm).norm(), 1e-8 * Hm.norm());
    EXPECT_LT((reduced.b - bm).norm(), 1e-8 * bm.norm());

    const NormalEquations rest = marginalizeFirst(reduced, 2);
    denseMarginal(H, b, 15, 30, &Hm, &bm);
    ASSERT_EQ(rest.blocks.size(), 4u);
    EXPECT_EQ(rest.blocks[0].offset, 0);
    EXPECT_EQ(rest.blocks[1].offset, 6);
    EXPECT_LT((rest.H - Hm).norm(), 1e-8 * Hm.norm());
    EXPECT_LT((rest.b - bm).norm(), 1e-8 * bm.norm());
    EXPECT_EQ(rest.H, rest.H.transpose());
    const MatrixXd P = Hm.inverse();
    EXPECT_LT((covarianceOf(rest) - P).norm(), 1e-7 * P.norm());

    const factors::LinearPrior prior = toPrior(rest);
    EXPECT_EQ(prior.r0.size(), 30);
    EXPECT_LT((prior.J.transpose() * prior.J - Hm).norm(), 1e-8 * Hm.norm());
    EXPECT_LT((prior.J.transpose() * prior.r0 - bm).norm(), 1e-8 * bm.norm());
  }
}

TEST(Marginalization, PriorStandsAtTheFirstEstimates) {
  RandomProblem problem(9);
  std::vector<BlockRef> frames = problem.frames();
  const NormalEquations plain = eliminateLandmarks(problem.terms, frames);
  vir_test::Blocks lin;
  for (const BlockRef& f : frames) {
    lin.emplace_back(f.data, f.data + f.ambient);
    if (f.ambient == 7) {
      factors::posePlus(f.data, std::vector<double>(6, 0.05).data(), lin.back().data());
    } else {
      lin.back()[2] -= 0.2;
    }
  }
  // The last frame has no first estimate yet: its prior stands at the current value.
  for (std::size_t k = 0; k < 4; ++k) frames[k].lin = lin[k].data();
  const NormalEquations eq = eliminateLandmarks(problem.terms, frames);
  EXPECT_EQ(eq.H, plain.H) << "where Jacobians are taken is the cost functions' matter";
  const factors::LinearPrior prior = toPrior(eq);
  VectorXd dx = VectorXd::Zero(kFrameColumns);
  for (std::size_t k = 0; k < 6; ++k) {
    const double* now = frames[k].data;
    const std::vector<double> current(now, now + frames[k].ambient);
    EXPECT_EQ(prior.blocks[k].x0, k < 4 ? lin[k] : current) << k;
    if (k >= 4) continue;
    double* delta = dx.data() + prior.blocks[k].offset;
    if (frames[k].ambient == 7) {
      factors::poseMinus(now, lin[k].data(), delta);
    } else {
      for (std::size_t i = 0; i < 9; ++i) delta[i] = now[i] - lin[k][i];
    }
  }
  // The gradient of the prior at the current values is that of the equations.
  EXPECT_LT((prior.J.transpose() * (prior.r0 + prior.J * dx) - eq.b).norm(), 1e-8 * eq.b.norm());
}

TEST(Marginalization, ADepthNoSightObservesIsLeftOut) {
  RandomProblem problem(3);
  problem.blindLandmarks();
  MatrixXd H, Hm;
  VectorXd b, bm;
  problem.dense(&H, &b);
  // Dense, with the blind columns pinned: they couple to nothing.
  for (int c = kFrameColumns + 2; c < H.cols(); c += 3) {
    ASSERT_EQ(H.col(c).norm(), 0);
    H(c, c) = 1;
  }
  denseMarginal(H, b, 0, kFrameColumns, &Hm, &bm);
  const NormalEquations eq = eliminateLandmarks(problem.terms, problem.frames());
  EXPECT_LT((eq.H - Hm).norm(), 1e-8 * Hm.norm());
  EXPECT_LT((eq.b - bm).norm(), 1e-8 * bm.norm());
}

TEST(Marginalization, GaugeDirectionsAreNotInvented) {
  // Three blocks in a chain that only differences tie: the sum is free, before and after.
  double x[9] = {}, y[9] = {}, z[9] = {};
  factors::LinearPrior between;
  between.blocks = {{9, 0, std::vector<double>(9, 0)}, {9, 9, std::vector<double>(9, 0)}};
  between.J = MatrixXd::Zero(9, 18);
  between.J.leftCols(9) = -10 * MatrixXd::Identity(9, 9);
  between.J.rightCols(9) = 10 * MatrixXd::Identity(9, 9);
  between.r0 = VectorXd::Zero(9);
  const factors::LinearPriorFactor f(between);
  std::vector<Term> terms(2);
  terms[0].cost = terms[1].cost = &f;
  terms[0].blocks = {x, y};
  terms[1].blocks = {y, z};
  const NormalEquations eq =
      eliminateLandmarks(terms, {{x, 9, 0, nullptr}, {y, 9, 0, nullptr}, {z, 9, 0, nullptr}});
  EXPECT_EQ(toPrior(eq).r0.size(), 18) << "27 columns, 9 of them gauge";
  // Without x, the second tie is left; without x and y, nothing.
  const NormalEquations two = marginalizeFirst(eq, 1);
  EXPECT_LT((two.H.topLeftCorner(9, 9) - 100 * MatrixXd::Identity(9, 9)).norm(), 1e-9);
  EXPECT_LT((two.H.topRightCorner(9, 9) + 100 * MatrixXd::Identity(9, 9)).norm(), 1e-9);
  EXPECT_EQ(toPrior(two).r0.size(), 9);
  EXPECT_TRUE(covarianceOf(two).allFinite());
  const NormalEquations one = marginalizeFirst(eq, 2);
  EXPECT_LT(one.H.norm(), 1e-9);
  EXPECT_LT(toPrior(one).J.norm(), 1e-4);
}

/// In a ring only neighbours are tied; how well the sum is known is another matter. What is left of
/// it behind the pivots of the others is the ring's length larger than its eigenvalue.
TEST(Marginalization, ADirectionIsLeftOutByItsEigenvalueNotByItsPivot) {
  constexpr int kSize = 20;
  std::vector<double> x(kSize);
  const auto ring = [&](double eigenvalue) {
    NormalEquations eq;
    eq.blocks = {{x.data(), kSize, 0, nullptr}};
    eq.H = MatrixXd::Constant(kSize, kSize, 2 * eigenvalue / kSize);
    for (int k = 0; k < kSize; ++k) {
      const int next = (k + 1) % kSize;
      eq.H(k, k) += 2;
      eq.H(k, next) -= 1;
      eq.H(next, k) -= 1;
    }
    eq.b = VectorXd::LinSpaced(kSize, -1, 1);
    return eq;
  };
  const factors::LinearPrior known = toPrior(ring(1e-9));
  ASSERT_EQ(known.r0.size(), kSize);
  EXPECT_LT((known.J.transpose() * known.J - ring(1e-9).H).norm(), 1e-13);
  EXPECT_LT((known.J.transpose() * known.r0 - ring(1e-9).b).norm(), 1e-9);
  const factors::LinearPrior unknown = toPrior(ring(5e-11));
  ASSERT_EQ(unknown.r0.size(), kSize - 1);
  EXPECT_LT((unknown.J.transpose() * unknown.J - ring(0).H).norm(), 1e-8);
  EXPECT_LT((unknown.J * VectorXd::Ones(kSize)).norm(), 1e-6);
}

TEST(Marginalization, AParameterThatWalks) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  NormalEquations eq;
  const MatrixXd A = MatrixXd::NullaryExpr(9, 6, [&] { return normal(random); });
  eq.H = A.transpose() * A;
  eq.b = VectorXd::NullaryExpr(6, [&] { return normal(random); });
  const NormalEquations before = eq;
  addProcessNoise(4, 0.3, &eq);
  MatrixXd covariance = before.H.inverse();
  covariance(4, 4) += 0.3;
  EXPECT_LT((eq.H.inverse() - covariance).norm(), 1e-9 * covariance.norm());
  EXPECT_LT((eq.H.ldlt().solve(eq.b) - before.H.ldlt().solve(before.b)).norm(), 1e-9)
      << "the minimum moves";

  NormalEquations unknown;
  unknown.H = MatrixXd::Identity(2, 2);
  unknown.H(1, 1) = 0;
  unknown.b = VectorXd::Zero(2);
  addProcessNoise(1, 0.3, &unknown);
  EXPECT_EQ(unknown.H(1, 1), 0) << "nothing was known: nothing is forgotten";
  EXPECT_EQ(unknown.H(0, 0), 1);
}

TEST(Marginalization, RobustWeightsAndConstantBlocks) {
  // r = 6, J = (2, 3): Huber at 1.5 weighs 1.5/6 = 1/4, Cauchy at 3 weighs 1/(1 + 36/9) = 1/5.
  factors::LinearPrior prior;
  prior.blocks = {{1, 0, {0}}, {1, 1, {0}}};
  prior.J = (MatrixXd(1, 2) << 2, 3).finished();
  prior.r0 = VectorXd::Constant(1, 6);
  const factors::LinearPriorFactor f(prior);
  double x = 0, y = 0;
  Term t;
  t.cost = &f;
  t.blocks = {&x, &y};
  const std::vector<BlockRef> only_y = {{&y, 1, 0, nullptr}};  // x is held constant
  const auto expect = [&](double H, double b) {
    const NormalEquations eq = eliminateLandmarks({t}, only_y);
    EXPECT_NEAR(eq.H(0, 0), H, 1e-14);
    EXPECT_NEAR(eq.b(0), b, 1e-14);
    EXPECT_EQ(eq.offsetOf(&x), -1);
    EXPECT_EQ(eq.offsetOf(&y), 0);
  };
  expect(9, 18);
  t.robust = 1.5;
  expect(9.0 / 4, 18.0 / 4);
  t.robust = 3;
  t.cauchy = true;
  expect(9.0 / 5, 18.0 / 5);
}

}  // namespace
}  // namespace vir::window
