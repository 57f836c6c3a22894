#include "vir/core/text_file.h"

#include <gtest/gtest.h>

#include <sstream>
#include <stdexcept>

#include "vir/core/text_stream.h"
#include "vir_test_temp_folder.h"
#include "vir_test_utf16.h"

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
  EXPECT_EQ(why(test::utf16("1")), "");
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

TEST(TextFile, Utf16IsReadAsUtf8) {
  const test::TempFolder folder;
  const std::string path = (folder / "t.csv").string();
  const auto read = [&](const std::string& bytes) {
    test::writeText(path, bytes);
    return readTextFile(path, 1 << 20);
  };
  std::string text;
  for (int i = 0; i < 9000; ++i) text += std::to_string(i) + ",0.5\r\n";
  for (const bool little : {true, false}) {
    for (const bool mark : {true, false}) {
      EXPECT_EQ(read(test::utf16(text, little, mark)), text) << little << mark;
    }
  }
  // Beyond ASCII: a micro sign, a Chinese one, one of two halves.
  EXPECT_EQ(read(std::string("\xFF\xFE\xB5\x00\x2D\x4E\x3D\xD8\x00\xDE", 10)),
            "\xC2\xB5\xE4\xB8\xAD\xF0\x9F\x98\x80");
  // Halves without the other, and half a character at the end.
  EXPECT_EQ(read(std::string("\xFF\xFE\x3D\xD8"
                             "a\0\x00\xDE"
                             "b\0\x3D\xD8",
                             12)),
            "\xEF\xBF\xBD"
            "a\xEF\xBF\xBD"
            "b\xEF\xBF\xBD");
  EXPECT_EQ(read("\xFF\xFE"), "");
  EXPECT_EQ(read("\xFF"), "\xFF");
  EXPECT_EQ(read(text), text);
}

TEST(TextFile, APlaceInUtf16IsOneInTheFile) {
  const test::TempFolder folder;
  const std::string path = (folder / "t.csv").string();
  test::writeText(path, test::utf16("one\ntwo\nthree\n"));
  TextStream in(path);
  EXPECT_TRUE(in.isUtf16());
  ASSERT_TRUE(in.seekg(0, std::ios::end));
  EXPECT_EQ(in.tellg(), std::streampos(2 + 2 * 14));
  std::string line;
  for (const int at : {10, 11}) {
    ASSERT_TRUE(in.seekg(at));
    ASSERT_TRUE(std::getline(in, line));
    EXPECT_EQ(line, "two") << at;
  }
  in.clear();
  ASSERT_TRUE(in.seekg(0));
  ASSERT_TRUE(std::getline(in, line));
  EXPECT_EQ(line, "one");
  EXPECT_FALSE(TextStream((folder / "nothere").string()));
  TextStream of_folder(folder.path().string());
  EXPECT_FALSE(std::getline(of_folder, line));
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
