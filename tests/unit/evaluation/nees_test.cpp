#include "vir/evaluation/nees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace vir::evaluation {
namespace {

TEST(Nees, ByHand) {
  Eigen::Vector2d e(2, 3);
  Eigen::Matrix2d P = Eigen::Vector2d(4, 0.25).asDiagonal();
  double value = 0;
  ASSERT_TRUE(nees(e, P, &value));
  EXPECT_DOUBLE_EQ(value, 1 + 36);  // 4/4 + 9/0.25
}

TEST(Nees, ACovarianceThatIsNone) {
  const Eigen::Vector2d e(1, 1);
  double value = 5;
  EXPECT_FALSE(nees(e, Eigen::Matrix2d::Zero(), &value));
  EXPECT_EQ(value, 0);
  EXPECT_FALSE(nees(e, Eigen::Vector2d(1, -1).asDiagonal().toDenseMatrix(), &value));
  EXPECT_FALSE(nees(e, Eigen::Matrix3d::Identity(), &value));
  EXPECT_FALSE(nees(e, Eigen::Matrix2d::Constant(NAN), &value));
  EXPECT_FALSE(nees(Eigen::Vector2d(NAN, 0), Eigen::Matrix2d::Identity(), &value));
}

TEST(Nees, ChiSquareQuantilesOfTheTables) {
  EXPECT_NEAR(chiSquareQuantile(1, 0.95), 3.841458820694124, 1e-9);
  EXPECT_NEAR(chiSquareQuantile(2, 0.95), 5.991464547107979, 1e-9);  // -2 ln 0.05
  EXPECT_NEAR(chiSquareQuantile(6, 0.95), 12.591587243743977, 1e-9);
  EXPECT_NEAR(chiSquareQuantile(100, 0.5), 99.33412923598846, 1e-7);
  EXPECT_NEAR(chiSquareQuantile(2, 0.01), -2 * std::log(0.99), 1e-12);
  EXPECT_THROW(chiSquareQuantile(0, 0.5), std::invalid_argument);
  EXPECT_THROW(chiSquareQuantile(1, 1), std::invalid_argument);
}

TEST(Nees, PoseErrorIsInTheOrderOfTheCovariance) {
  const Pose ref(expQuat(Vec3(0.3, 0.2, 2)), Vec3(1, 2, 3));
  const Vec3 d(0.01, -0.02, 0.03);
  const Pose est(ref.q * expQuat(d), ref.p + Vec3(0.1, 0.2, 0.3));
  const auto e = poseError(ref, est);
  EXPECT_LT((e.head<3>() - Vec3(0.1, 0.2, 0.3)).norm(), 1e-15);
  EXPECT_LT((e.tail<3>() - d).norm(), 1e-15);
}

TEST(Nees, SummaryOfConsistentErrors) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  std::vector<double> values;
  for (int i = 0; i < 20000; ++i) {
    double sum = 0;
    for (int k = 0; k < 6; ++k) sum += std::pow(normal(generator), 2);
    values.push_back(sum);
  }
  const NeesSummary s = summariseNees(values, 6);
  EXPECT_EQ(s.count, 20000);
  EXPECT_NEAR(s.mean_per_dof, 1, 0.01);
  EXPECT_NEAR(s.share_below_95, 0.95, 0.005);
  EXPECT_EQ(summariseNees({}, 6).count, 0);
}

}  // namespace
}  // namespace vir::evaluation
