#include "vir/core/text.h"

#include <gtest/gtest.h>

namespace vir {
namespace {

TEST(Text, LowerCaseLeavesAllButLetters) {
  EXPECT_EQ(lowerCase("Cam0_\xC3\x84.PNG"), "cam0_\xC3\x84.png");
}

TEST(Text, TrimmedOnBothSides) {
  EXPECT_EQ(trimmed(" \ta b\r\n"), "a b");
  EXPECT_EQ(trimmed("\"a\"", " \""), "a");
  EXPECT_EQ(trimmed(" \t"), "");
  EXPECT_EQ(trimmed(""), "");
}

TEST(Text, WordsStandBetweenBlanks) {
  using Words = std::vector<std::string_view>;
  EXPECT_EQ(wordsOf("  1 two\t3\r"), (Words{"1", "two", "3"}));
  EXPECT_EQ(wordsOf("1,, 2,", ", "), (Words{"1", "2"}));
  EXPECT_EQ(wordsOf(" "), Words{});
}

}  // namespace
}  // namespace vir
