/// The window's own solver against Ceres, on a window as the estimator makes it.
#include "minimiser.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "solver_window.h"

namespace vir::window {
namespace {

using vir_test::SolverWindow;
using vir_test::WindowVariant;

constexpr int kFrames = SolverWindow::kFrames;

double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double out = 0;
  for (std::size_t k = 0; k < a.size(); ++k) out = std::max(out, std::abs(a[k] - b[k]));
  return out;
}

void expectAsCeres(const WindowVariant& v, int iterations, double tolerance) {
  SolverWindow w(v);
  const std::vector<double> start = w.values();
  const double cost = w.solveByCeres(iterations);
  const std::vector<double> theirs = w.values();
  EXPECT_GT(largestDifference(theirs, start), 1e-3) << "the test must move something";
  w.setValues(start);
  Minimiser minimiser;
  const Minimised m = minimiser.minimise(w.problem(), iterations);
  ASSERT_TRUE(m.usable);
  EXPECT_LT(largestDifference(w.values(), theirs), tolerance);
  EXPECT_NEAR(m.sums.cost, cost, 1e-9 * cost);
  EXPECT_EQ(m.iterations, w.ceres_iterations);
}

TEST(Minimiser, OneStepIsThatOfCeres) {
  for (const bool calibrated : {true, false}) {
    for (const bool cauchy : {true, false}) {
      for (const bool ranges : {true, false}) {
        SCOPED_TRACE(testing::Message() << calibrated << cauchy << ranges);
        expectAsCeres({calibrated, cauchy, ranges}, 1, 1e-9);
      }
    }
  }
}

TEST(Minimiser, ConvergesAsCeresDoes) {
  expectAsCeres({true, true, true}, 2, 1e-8);
  expectAsCeres({true, true, true}, 30, 1e-7);
  expectAsCeres({false, false, false}, 30, 1e-7);
}

TEST(Minimiser, StepsThatMakeThingsWorseAreTakenBackAsByCeres) {
  WindowVariant far{true, true, true};
  far.disturb = 0.5;
  SolverWindow w(far);
  const std::vector<double> start = w.values();
  const double cost = w.solveByCeres(6);
  w.setValues(start);
  Minimiser minimiser;
  const Minimised m = minimiser.minimise(w.problem(), 6);
  EXPECT_EQ(m.iterations, w.ceres_iterations);
  EXPECT_NEAR(m.sums.cost, cost, 1e-6 * cost);
  EXPECT_LT(m.sums.cost, m.initial_cost);
}

TEST(Minimiser, MemoryOfAnotherProblemChangesNothing) {
  SolverWindow a({true, true, true}), b({true, true, true}), other({false, true, false});
  Minimiser fresh, used;
  used.minimise(other.problem(), 3);
  fresh.minimise(a.problem(), 3);
  used.minimise(b.problem(), 3);
  EXPECT_EQ(a.values(), b.values());
}

TEST(Minimiser, WhatIsNotFiniteIsNotUsableAndChangesNothing) {
  SolverWindow w({true, true, true});
  std::vector<double> start = w.values();
  start[0] = std::nan("");
  w.setValues(start);
  Minimiser minimiser;
  EXPECT_FALSE(minimiser.minimise(w.problem(), 3).usable);
  EXPECT_TRUE(minimiser.information().blocks.empty());
  const std::vector<double> after = w.values();
  EXPECT_TRUE(std::isnan(after[0]));
  EXPECT_TRUE(std::equal(after.begin() + 1, after.end(), start.begin() + 1));
}

TEST(Minimiser, InformationIsTheMarginalOfWhatWasLinearised) {
  SolverWindow w({true, true, true});
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  w.dense(&H, &b);
  Minimiser minimiser;
  ASSERT_TRUE(minimiser.minimise(w.problem(), 1).usable);
  const NormalEquations& found = minimiser.information();
  constexpr int kSpeeds = 9 * kFrames, kRest = 6 * kFrames + 6 + 8 + 9;
  const Eigen::MatrixXd P = H.inverse();
  const Eigen::MatrixXd marginal = P.block(kSpeeds, kSpeeds, kRest, kRest).inverse();
  const Eigen::VectorXd gradient = marginal * (P * b).segment(kSpeeds, kRest);
  ASSERT_EQ(found.H.rows(), kRest + 9) << "head and anchor are behind";
  EXPECT_LT((found.H.topLeftCorner(kRest, kRest) - marginal).norm(), 1e-5 * marginal.norm());
  EXPECT_LT((found.b.head(kRest) - gradient).norm(), 1e-5 * gradient.norm());
  EXPECT_EQ(found.H.bottomRows(9).norm(), 0) << "ranges are no part of it";
}

TEST(LeadingBlocks, AgainstTheDenseSolution) {
  srand(7);
  constexpr int kSize = 30;
  Eigen::MatrixXd J = Eigen::MatrixXd::Random(50, kSize);
  J.block(0, 0, 50, 4).topRows(40).setZero();  // touches little
  J.block(40, 10, 10, 12).setZero();
  const Eigen::MatrixXd H = J.transpose() * J + Eigen::MatrixXd::Identity(kSize, kSize);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(kSize);
  const Eigen::VectorXd expected = -H.ldlt().solve(b);
  Eigen::MatrixXd work = H.triangularView<Eigen::Upper>();
  Eigen::VectorXd right = b;
  LeadingBlocks blocks;
  ASSERT_TRUE(blocks.eliminate({4, 3, 5}, &work, &right));
  const int rest = kSize - 12;
  const Eigen::MatrixXd marginal = H.inverse().bottomRightCorner(rest, rest).inverse();
  Eigen::MatrixXd left = work.bottomRightCorner(rest, rest);
  left.triangularView<Eigen::StrictlyLower>() = left.transpose();
  EXPECT_LT((left - marginal).norm(), 1e-12 * marginal.norm());
  Eigen::VectorXd x(kSize);
  x.tail(rest) = -left.ldlt().solve(right.tail(rest));
  blocks.backSubstitute(&x);
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());

  Eigen::MatrixXd indefinite = H.triangularView<Eigen::Upper>();
  indefinite(5, 5) = -1;
  EXPECT_FALSE(blocks.eliminate({4, 3, 5}, &indefinite, &right));
}

}  // namespace
}  // namespace vir::window
