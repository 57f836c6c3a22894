/// Observations of any number and stamp in any order: no crash, no hang, no NaN.
#include <gtest/gtest.h>

#include <random>

#include "vir_test_random_input.h"

namespace vir::estimator {
namespace {

/// The yardstick: undisturbed it flies.
TEST(RandomInput, UndisturbedItFlies) {
  const std::vector<std::uint8_t> bytes(100, 0);
  test::RandomInput input(bytes.data(), bytes.size());
  EXPECT_EQ(input.run(), "");
  EXPECT_GT(input.poses(), 50);
}

TEST(RandomInput, NothingThatComesInMakesAStateThatIsNoNumber) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bytes(400);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random() % 256);
    // The flight has to begin before there is something to spoil.
    if (seed % 2 == 0) std::fill(bytes.begin(), bytes.begin() + 60, 0);
    EXPECT_EQ(test::RandomInput(bytes.data(), bytes.size()).run(), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace vir::estimator
