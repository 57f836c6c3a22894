#include "vir/core/thinned_out.h"

#include <gtest/gtest.h>

namespace vir {
namespace {

TEST(ThinnedOut, KeepsAllUntilThereAreTooMany) {
  ThinnedOut<int> thinned(10);
  for (int i = 0; i < 19; ++i) thinned.add(i);
  ASSERT_EQ(thinned.values().size(), 19u);
  for (int i = 0; i < 19; ++i) EXPECT_EQ(thinned.values()[static_cast<std::size_t>(i)], i);
}

TEST(ThinnedOut, KeepsThemEvenly) {
  ThinnedOut<int> thinned(10);
  for (int i = 0; i < 1000; ++i) thinned.add(i);
  const std::vector<int>& kept = thinned.values();
  ASSERT_GE(kept.size(), 10u);
  ASSERT_LT(kept.size(), 20u);
  for (std::size_t k = 1; k < kept.size(); ++k) EXPECT_EQ(kept[k] - kept[k - 1], kept[1]);
  EXPECT_EQ(kept.front(), 0);
  EXPECT_GT(kept.back(), 900);
}

TEST(ThinnedOut, KeepsThoseThatBelongTogether) {
  ThinnedOut<int> thinned(12, 4);
  for (int i = 0; i < 1000; ++i) thinned.add(i);
  const std::vector<int>& kept = thinned.values();
  ASSERT_GE(kept.size(), 12u);
  ASSERT_LT(kept.size(), 24u);
  const int stride = kept[4];
  for (std::size_t k = 0; k < kept.size(); ++k) {
    EXPECT_EQ(kept[k], static_cast<int>(k / 4) * stride + static_cast<int>(k % 4));
  }
  EXPECT_GE(kept.back(), 999 - stride);
}

/// What is added later goes on where the thinning left off, however often it was thinned out.
TEST(ThinnedOut, NeverTakesMoreMemory) {
  ThinnedOut<int> thinned(64, 8);
  for (int i = 0; i < 128; ++i) thinned.add(i);
  const std::size_t room = thinned.values().capacity();
  for (int i = 0; i < 1000000; ++i) thinned.add(i);
  EXPECT_EQ(thinned.values().capacity(), room);
}

}  // namespace
}  // namespace vir
