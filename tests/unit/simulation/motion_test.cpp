/// Poses, rates and accelerations of a simulated motion belong together.
#include <gtest/gtest.h>

TEST(Motion, Placeholder) {}
