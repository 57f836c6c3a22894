#include "vir/geometry/axes.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace vir {
namespace {

TEST(Axes, RotationsOnly) {
  EXPECT_EQ(axesRotation("x -y -z") * Vec3(1, 2, 3), Vec3(1, -2, -3));
  EXPECT_EQ(axesRotation("y z x") * Vec3(1, 2, 3), Vec3(2, 3, 1));
  EXPECT_EQ(axesRotation("+x -z +y") * Vec3(1, 2, 3), Vec3(1, -3, 2));
  for (const char* text :
       {"", "x y", "x y -z", "x x z", "y x z", "x y z z", "a b c", "xy z", "-"}) {
    EXPECT_THROW(axesRotation(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace vir
