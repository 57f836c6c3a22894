#include "vir/places/hamming.h"

#include <gtest/gtest.h>

#include <bitset>

#include "vir/core/random.h"

namespace {

using vir::places::Descriptor;
using vir::places::hammingDistance;

TEST(Hamming, CountsEveryBitOnce) {
  const Descriptor zero{};
  for (int bit = 0; bit < 256; ++bit) {
    Descriptor one{};
    one[static_cast<std::size_t>(bit / 8)] = static_cast<std::uint8_t>(1 << (bit % 8));
    ASSERT_EQ(hammingDistance(zero, one), 1) << bit;
    ASSERT_EQ(hammingDistance(one, one), 0) << bit;
  }
  Descriptor all;
  all.fill(255);
  EXPECT_EQ(hammingDistance(zero, all), 256);
}

TEST(Hamming, IsWhatCountingByByteGives) {
  vir::Random random(3);
  for (int k = 0; k < 1000; ++k) {
    Descriptor a, b;
    std::size_t sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      a[i] = static_cast<std::uint8_t>(random.below(256));
      b[i] = static_cast<std::uint8_t>(random.below(256));
      sum += std::bitset<8>(a[i] ^ b[i]).count();
    }
    ASSERT_EQ(hammingDistance(a, b), static_cast<int>(sum));
  }
}

}  // namespace
