#include "vir/factors/linear_prior_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vir_test_jacobian.h"
#include "vir_test_poses.h"

namespace vir::factors {
namespace {

using vir_test::poseBlock;

LinearPrior randomPrior(const Pose& T0, int rows) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  LinearPrior prior;
  prior.blocks = {{7, 0, poseBlock(T0)}, {9, 6, std::vector<double>(9, 0.5)}, {1, 15, {0.1}}};
  prior.J.resize(rows, 16);
  prior.r0.resize(rows);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < 16; ++c) prior.J(r, c) = normal(random);
    prior.r0[r] = normal(random);
  }
  return prior;
}

TEST(LinearPriorFactor, JacobiansEverywhere) {
  for (int rows : {3, 16, 20}) {
    for (const vir_test::NamedPose& p : vir_test::poses()) {
      const LinearPrior prior = randomPrior(p.T, rows);
      const LinearPriorFactor f(prior);
      for (double away : {0.0, 0.01, 1.0}) {
        const Pose T(p.T.q * expQuat(away * Vec3(1, -1.5, 0.5)), p.T.p + away * Vec3(1, 2, 3));
        std::vector<double> sb(9, 0.5);
        sb[4] += away;
        vir_test::expectJacobians(f, {poseBlock(T), sb, {0.1 - away}},
                                  p.name + ", away " + std::to_string(away));
      }
    }
  }
}

TEST(LinearPriorFactor, ResidualByHand) {
  // One row: 2 * dx + 3 * dtheta_z + 5 * d(last) + 0.5, pose at (1, 0, 0), scalar at 0.1.
  LinearPrior prior;
  prior.blocks = {{7, 0, poseBlock(Pose(Quat::Identity(), Vec3(1, 0, 0)))}, {1, 6, {0.1}}};
  prior.J = Eigen::MatrixXd::Zero(1, 7);
  prior.J(0, 0) = 2;
  prior.J(0, 5) = 3;
  prior.J(0, 6) = 5;
  prior.r0 = Eigen::VectorXd::Constant(1, 0.5);
  const LinearPriorFactor f(prior);
  // dx = 0.25, dtheta_z = 0.2, d = 0.3: 0.5 + 0.6 + 1.5 + 0.5 = 3.1
  const Pose T(expQuat(Vec3(0, 0, 0.2)), Vec3(1.25, 0, 0));
  EXPECT_NEAR(vir_test::residualOf(f, {poseBlock(T), {0.4}})[0], 3.1, 1e-14);
}

TEST(LinearPriorFactor, ResidualAtTheFirstEstimateIsR0) {
  const LinearPrior prior = randomPrior(vir_test::poses()[3].T, 16);
  const LinearPriorFactor f(prior);
  EXPECT_EQ(f.num_residuals(), 16);
  EXPECT_EQ(f.parameter_block_sizes(), (std::vector<int>{7, 9, 1}));
  EXPECT_LT(
      (vir_test::residualOf(f, {prior.blocks[0].x0, prior.blocks[1].x0, {0.1}}) - prior.r0).norm(),
      1e-14);
}

TEST(LinearPriorFactor, NormalEquationsAreThoseOfItsJacobians) {
  const Pose T0 = vir_test::poses()[3].T;
  const LinearPrior prior = randomPrior(T0, 12);
  const LinearPriorFactor f(prior);
  const std::vector<std::vector<double>> x = {
      poseBlock(T0 * Pose(expQuat(Vec3(0.3, -0.2, 0.4)), Vec3(1, 0, 2))),
      std::vector<double>(9, 0.7),
      {-0.4}};
  Eigen::VectorXd r;
  const auto blocks = vir_test::analyticJacobians(f, x, &r);
  Eigen::MatrixXd J(12, 16);
  J << blocks[0].leftCols(6), blocks[1], blocks[2];
  const double* at[3] = {x[0].data(), x[1].data(), x[2].data()};
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double squared = 0;
  f.linearize(at, &H, &b, &squared);
  EXPECT_LT((H - J.transpose() * J).norm(), 1e-12 * H.norm());
  EXPECT_LT((b - J.transpose() * r).norm(), 1e-12 * b.norm());
  EXPECT_NEAR(squared, r.squaredNorm(), 1e-12 * squared);
}

TEST(LinearPriorFactor, BothQuaternionsOfAPoseAreTheSame) {
  const Pose T0 = vir_test::poses().back().T;
  const LinearPrior prior = randomPrior(T0, 16);
  const LinearPriorFactor f(prior);
  std::vector<double> x = poseBlock(T0 * Pose(expQuat(Vec3(0.1, 0.2, 0)), Vec3(1, 0, 0)));
  const Eigen::VectorXd r = vir_test::residualOf(f, {x, std::vector<double>(9, 0), {0}});
  for (int k = 3; k < 7; ++k) x[static_cast<std::size_t>(k)] *= -1;
  EXPECT_EQ(vir_test::residualOf(f, {x, std::vector<double>(9, 0), {0}}), r);
}

}  // namespace
}  // namespace vir::factors
