#include "stamp_jitter.h"

#include <gtest/gtest.h>

#include <limits>

#include "vir/core/random.h"

namespace vir::estimator {
namespace {

TEST(StampJitter, StampsThatAreRightAreLeftAlone) {
  StampJitter jitter;
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    jitter.add(0.001 * random.normal());
    EXPECT_EQ(jitter.sigma(), 0);
  }
}

/// A clock that is off is another matter, and so is a single image.
TEST(StampJitter, AnOffsetIsNone) {
  StampJitter jitter;
  for (int i = 0; i < 500; ++i) {
    jitter.add(i % 50 == 7 ? 0.2 : 0.02);
    EXPECT_EQ(jitter.sigma(), 0);
  }
}

TEST(StampJitter, IsFoundAndForgotten) {
  StampJitter jitter;
  Random random(2);
  for (int i = 0; i < 19; ++i) jitter.add(0.006 * random.normal());
  EXPECT_EQ(jitter.sigma(), 0) << "too few to tell";
  for (int i = 0; i < 100; ++i) jitter.add(0.006 * random.normal());
  EXPECT_NEAR(jitter.sigma(), 0.006, 0.002);
  jitter.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NEAR(jitter.sigma(), 0.006, 0.002);
  for (int i = 0; i < 60; ++i) jitter.add(0.0005 * random.normal());
  EXPECT_EQ(jitter.sigma(), 0);
}

}  // namespace
}  // namespace vir::estimator
