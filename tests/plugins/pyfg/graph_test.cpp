/// Whole files: what is said twice, names nothing, is cut off, or is no graph.
#include "graph.h"

#include <gtest/gtest.h>

#include "input_error.h"
#include "vir_test_pyfg.h"
#include "vir_test_temp_folder.h"

namespace vir::pyfg {
namespace {

class GraphFile : public ::testing::Test {
 protected:
  Graph read(const std::string& text) {
    log = {};
    test::writeText(folder / "g.pyfg", text);
    return readGraph((folder / "g.pyfg").string(), &log);
  }
  std::string said() const {
    std::string all;
    for (const auto& m : log.messages()) all += m + "\n";
    return all;
  }
  test::TempFolder folder;
  ProblemLog log;
};

TEST_F(GraphFile, AGoodOneIsReadWithoutAWord) {
  const Graph g = read(test::twoRobots(5));
  EXPECT_EQ(g.vertices.size(), 10u);
  EXPECT_EQ(g.motions.size(), 8u);
  EXPECT_EQ(g.ranges.size(), 15u);
  EXPECT_EQ(g.landmarks.size(), 1u);
  EXPECT_EQ(g.robots(), (std::set<char>{'A', 'B'}));
  EXPECT_TRUE(log.counters().empty());
  EXPECT_EQ(said(), "");
}

TEST_F(GraphFile, DosLineEndsCommentsAndBlankLines) {
  std::string text;
  for (const char c : test::twoRobots(3)) text += c == '\n' ? "\r\n" : std::string(1, c);
  const Graph g = read("\xEF\xBB\xBF# a comment\r\n\r\n" + text);
  EXPECT_EQ(g.ranges.size(), 9u);
  EXPECT_TRUE(log.counters().empty()) << said();
}

TEST_F(GraphFile, BadLinesAreCountedWithFileAndLine) {
  const Graph g = read("VERTEX_SE2 1 A0 0 0 0\nnonsense\nEDGE_RANGE 1 A0 L0 nan 1\n" +
                       test::range(2, "A0", "L0", 3));
  EXPECT_EQ(g.ranges.size(), 1u);
  EXPECT_EQ(log.get("line_unknown_keyword"), 1);
  EXPECT_EQ(log.get("line_not_finite"), 1);
  EXPECT_NE(said().find("g.pyfg:2: `nonsense`"), std::string::npos) << said();
  EXPECT_NE(said().find("g.pyfg:3: "), std::string::npos) << said();
}

TEST_F(GraphFile, ALastLineWithoutLineBreakIsNotUsed) {
  std::string text = test::twoRobots(3);
  text.pop_back();
  EXPECT_EQ(read(text).ranges.size(), 8u);
  EXPECT_EQ(log.get("line_cut"), 1);
}

TEST_F(GraphFile, OfThingsSaidTwiceTheFirstCounts) {
  const Graph g = read(
      "VERTEX_SE2 1 A0 0 0 0\nVERTEX_SE2 1 A0 5 0 0\nVERTEX_XY L0 1 1\n"
      "VERTEX_XY L0 2 2\n" +
      test::motion2('A', 0, 1, 2, 1, 0, 0) + test::motion2('A', 0, 1, 3, 9, 0, 0) +
      test::range(2, "A0", "L0", 3) + test::range(2, "A0", "L0", 4));
  ASSERT_EQ(g.vertices.size(), 1u);
  EXPECT_DOUBLE_EQ(g.vertices[0].item.T_W_B.p.x(), 0);
  ASSERT_EQ(g.motions.size(), 1u);
  EXPECT_DOUBLE_EQ(g.motions[0].item.T_from_to.p.x(), 1);
  ASSERT_EQ(g.ranges.size(), 1u);
  EXPECT_DOUBLE_EQ(g.ranges[0].item.range_m, 3);
  EXPECT_DOUBLE_EQ(g.landmarks.at({'L', 0}).p_W.x(), 1);
  for (const char* kind :
       {"vertex_repeated", "motion_repeated", "range_repeated", "landmark_repeated"}) {
    EXPECT_EQ(log.get(kind), 1) << kind;
  }
}

TEST_F(GraphFile, RangesOfPosesNobodyKnowsAreNotUsed) {
  const Graph g = read("VERTEX_SE2 1 A0 0 0 0\n" + test::range(2, "A0", "L5", 3) +
                       test::range(2, "A7", "L5", 3) + test::range(2, "A0", "C1", 3));
  EXPECT_EQ(g.ranges.size(), 1u) << "a landmark need not be known";
  EXPECT_EQ(log.get("range_unknown_vertex"), 2);
  EXPECT_NE(said().find("g.pyfg:3: a range names A7"), std::string::npos) << said();
}

TEST_F(GraphFile, ARobotMayBeCalledL) {
  const Graph g = read("VERTEX_SE2 1 L0 0 0 0\n" + test::range(2, "L9", "L0", 3));
  EXPECT_EQ(g.robots(), std::set<char>{'L'});
  EXPECT_EQ(log.get("range_unknown_vertex"), 1);
}

TEST_F(GraphFile, NoGraphAtAllIsAnError) {
  for (const std::string& text : {std::string(), std::string("\n\n"),
                                  std::string("VERTEX_XY L0 1 1\n"), std::string(100000, '\0'),
                                  std::string("\x7f"
                                              "ELF\n\n\n")}) {
    EXPECT_THROW(read(text), InputError);
  }
  EXPECT_THROW(readGraph((folder / "none").string(), &log), InputError);
  EXPECT_THROW(readGraph(folder.path().string(), &log), InputError);
  try {
    read("hello\n");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("g.pyfg:1: `hello`"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace vir::pyfg
