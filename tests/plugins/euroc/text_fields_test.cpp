#include "text_fields.h"

#include <gtest/gtest.h>

#include "input_error.h"
#include "vir_test_temp_folder.h"

namespace vir::euroc {
namespace {

std::vector<std::string> linesOf(const std::string& text, bool* open_end = nullptr) {
  test::TempFolder temp;
  test::writeText(temp / "f.csv", text);
  LineReader reader((temp / "f.csv").string());
  std::vector<std::string> out;
  std::string line;
  while (reader.next(&line)) out.push_back(line);
  if (open_end) *open_end = reader.lastLineOpen();
  return out;
}

TEST(LineReader, DropsBomCommentsBlankLinesAndCarriageReturns) {
  bool open_end = true;
  const auto lines = linesOf("\xEF\xBB\xBF#head\r\n1,2\r\n\r\n  # note\r\n3,4\r\n", &open_end);
  EXPECT_EQ(lines, (std::vector<std::string>{"1,2", "3,4"}));
  EXPECT_FALSE(open_end);
}

TEST(LineReader, CountsEveryLineOfTheFile) {
  test::TempFolder temp;
  test::writeText(temp / "f.csv", "#head\n\n1\n");
  LineReader reader((temp / "f.csv").string());
  std::string line;
  ASSERT_TRUE(reader.next(&line));
  EXPECT_EQ(reader.lineNumber(), 3);
  EXPECT_FALSE(reader.next(&line));
  EXPECT_DOUBLE_EQ(reader.progress(), 1.0);
}

TEST(LineReader, SaysThatTheLastLineHasNoBreak) {
  bool open_end = false;
  EXPECT_EQ(linesOf("1,2\n3,", &open_end).size(), 2u);
  EXPECT_TRUE(open_end);
}

TEST(LineReader, AnEndlessLineDoesNotFillTheMemory) {
  const auto lines = linesOf(std::string(3'000'000, 'x') + "\n1,2\n");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_LE(lines[0].size(), 10'000u);
  EXPECT_EQ(lines[1], "1,2");
}

TEST(LineReader, AMissingFileIsNamed) {
  try {
    LineReader reader("/nonexistent/data.csv");
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("/nonexistent/data.csv"), std::string::npos);
  }
}

TEST(Fields, SplitsAtCommasOrElseAtBlanks) {
  std::vector<std::string_view> f;
  splitFields("1, 2 ,,3", &f);
  EXPECT_EQ(f, (std::vector<std::string_view>{"1", "2", "", "3"}));
  splitFields("1.5  2\t3", &f);
  EXPECT_EQ(f, (std::vector<std::string_view>{"1.5", "2", "3"}));
}

}  // namespace
}  // namespace vir::euroc
