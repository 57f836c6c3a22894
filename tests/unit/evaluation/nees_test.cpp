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

TEST(Nees, MeanOfConsistentErrors) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  std::vector<double> values;
  for (int i = 0; i < 20000; ++i) {
    double sum = 0;
    for (int k = 0; k < 6; ++k) sum += std::pow(normal(generator), 2);
    values.push_back(sum);
  }
  EXPECT_NEAR(meanNeesPerDof(values, 6), 1, 0.01);
  EXPECT_EQ(meanNeesPerDof({}, 6), 0);
}

}  // namespace
}  // namespace vir::evaluation
