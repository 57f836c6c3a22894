#include "vir/core/order_statistics.h"

#include <gtest/gtest.h>

namespace vir {
namespace {

TEST(OrderStatistics, MedianIsTheUpperOneOfTwo) {
  EXPECT_EQ(median<double>({}), 0);
  EXPECT_EQ(median<double>({4}), 4);
  EXPECT_EQ(median<double>({4, 1}), 4);
  EXPECT_EQ(median<double>({9, 1, 5}), 5);
  EXPECT_EQ(median<double>({9, 1, 5, 7}), 7);
  EXPECT_EQ(median<long>({3, 3, 1}), 3);
}

TEST(OrderStatistics, QuantilesReachFromTheLeastToTheLargest) {
  std::vector<float> v{5, 3, 1, 4, 2};
  EXPECT_EQ(quantileInPlace(&v, 0), 1);
  EXPECT_EQ(quantileInPlace(&v, 0.5), 3);
  EXPECT_EQ(quantileInPlace(&v, 0.74), 3);
  EXPECT_EQ(quantileInPlace(&v, 0.75), 4);
  EXPECT_EQ(quantileInPlace(&v, 1), 5);
  v.clear();
  EXPECT_EQ(quantileInPlace(&v, 0.5), 0);
}

TEST(OrderStatistics, QuantilesBetweenTwoOfTheSorted) {
  EXPECT_EQ(quantileOfSorted({}, 0.5), 0);
  EXPECT_EQ(quantileOfSorted({4}, 0.95), 4);
  EXPECT_EQ(quantileOfSorted({1, 4}, 0.5), 2.5);
  EXPECT_EQ(quantileOfSorted({1, 4, 9}, 0.5), 4);
  EXPECT_EQ(quantileOfSorted({1, 4, 9}, 0.75), 6.5);
  EXPECT_EQ(quantileOfSorted({1, 4, 9}, 0), 1);
  EXPECT_EQ(quantileOfSorted({1, 4, 9}, 1), 9);
}

}  // namespace
}  // namespace vir
