#include "vir/core/assert.h"

#include <gtest/gtest.h>

namespace vir {
namespace {

TEST(Assert, SaysExpressionPlaceAndValues) {
  const int n = -3;
  try {
    VIR_ASSERT(n > 0, "n = " << n);
    FAIL();
  } catch (const AssertionError& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("n > 0"), std::string::npos) << text;
    EXPECT_NE(text.find("assert_test.cpp:"), std::string::npos) << text;
    EXPECT_NE(text.find("n = -3"), std::string::npos) << text;
  }
  EXPECT_NO_THROW(VIR_ASSERT(n < 0, n));
}

}  // namespace
}  // namespace vir
