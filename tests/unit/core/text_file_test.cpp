#include "vir/core/text_file.h"

#include <gtest/gtest.h>

#include <sstream>
#include <stdexcept>

#include "vir_test_temp_folder.h"

namespace vir {
namespace {

TEST(TextFile, LinesAsGetlineReadsThem) {
  for (const std::string text : {"", "a", "a\n", "\n\n", "a\nb", "a\r\nb\n"}) {
    std::istringstream one(text), other(text);
    std::string line, expected;
    while (std::getline(other, expected)) {
      ASSERT_TRUE(readLine(one, &line)) << text;
      EXPECT_EQ(line, expected) << text;
    }
    EXPECT_FALSE(readLine(one, &line)) << text;
    EXPECT_TRUE(one.eof());
  }
}

TEST(TextFile, WhyThereIsNoText) {
  const test::TempFolder folder;
  const auto why = [&](const std::string& text) {
    test::writeText(folder / "t.csv", text);
    return whyNoText((folder / "t.csv").string());
  };
  EXPECT_EQ(why(""), "is empty");
  EXPECT_EQ(why(std::string("\xFF\xFE"
                            "1\0",
                            4)),
            "is text in UTF-16: save it as UTF-8 (iconv -f UTF-16 -t UTF-8 OLD > NEW)");
  EXPECT_EQ(why(std::string("\xFE\xFF\0"
                            "1",
                            4)),
            why(std::string("\xFF\xFE"
                            "1\0",
                            4)));
  for (const char* text : {"1", "\n", "1,2\n",
                           "\xEF\xBB\xBF"
                           "1,2\n"})
    EXPECT_EQ(why(text), "");
  EXPECT_EQ(whyNoText((folder / "nothere").string()), "");
  EXPECT_EQ(whyNoText(folder.path().string()), "");
}

TEST(TextFile, ALineWithoutEndIsCut) {
  std::istringstream in(std::string(3 * kLongestLine, 'x') + "\nnext\n");
  std::string line;
  ASSERT_TRUE(readLine(in, &line));
  EXPECT_EQ(line.size(), kLongestLine);
  ASSERT_TRUE(readLine(in, &line));
  EXPECT_EQ(line, "next");
}

std::string errorOf(const std::string& path) {
  try {
    readTextFile(path, 1000);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "no error";
}

TEST(TextFile, WhatIsNoTextFile) {
  const test::TempFolder folder;
  EXPECT_EQ(errorOf("/dev/zero"), "this is a device, not a file");
  EXPECT_EQ(errorOf(folder.path().string()), "this is a folder, not a file");
  EXPECT_EQ(errorOf("/nowhere/a"), "there is no such file");
  test::writeText(folder / "large", std::string(1001, 'x'));
  EXPECT_EQ(errorOf((folder / "large").string()), "it is larger than 1 kB, which no such file is");
  test::writeText(folder / "fits", std::string(1000, 'x'));
  EXPECT_EQ(readTextFile((folder / "fits").string(), 1000).size(), 1000u);
}

}  // namespace
}  // namespace vir
