/// `vir-slam import pyfg` as a user calls it.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_data.h"
#include "vir_test_pyfg.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::contains;

class PyfgImport : public ::testing::Test {
 protected:
  test::Outcome import(const fs::path& graph, const std::string& more = "") {
    return test::virSlam("import pyfg " + test::quoted(graph.string()) + " --out " +
                         test::quoted(rawlog().string()) + " " + more);
  }
  test::Outcome importText(const std::string& text, const std::string& more = "") {
    test::writeText(folder / "g.pyfg", text);
    return import(folder / "g.pyfg", more);
  }
  std::map<std::string, int> labels() {
    std::map<std::string, int> counts;
    rawlog::RawlogReader reader(rawlog().string());
    while (const auto o = reader.next()) ++counts[o->sensorLabel];
    return counts;
  }
  fs::path rawlog() const { return folder / "out/x.rawlog"; }
  fs::path truth() const { return folder / "out/x_anchors_truth.csv"; }
  test::TempFolder folder;
};

using Labels = std::map<std::string, int>;

TEST_F(PyfgImport, WritesRawlogAndTrueAnchors) {
  const auto o = importText(test::twoRobots(20), "--set pyfg.robot=A");
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(labels(), (Labels{{"GT", 20}, {"ODOM", 20}, {"PEER", 20}, {"UWB0", 20}}));
  EXPECT_EQ(test::readText(truth()), "#id,x,y,z in the ground truth's frame [m]\n7,4.5,-1.5,0\n");
  EXPECT_TRUE(contains(o.text, "robot B is beacon 1")) << o.text;
  EXPECT_TRUE(contains(o.text, "x_anchors_truth.csv")) << o.text;
}

TEST_F(PyfgImport, ASecondImportReplacesTheFirst) {
  ASSERT_EQ(importText(test::twoRobots(20), "--set pyfg.robot=A").code, 0);
  const std::string first = test::readText(rawlog());
  ASSERT_EQ(importText(test::twoRobots(20), "--set pyfg.robot=A").code, 0);
  EXPECT_EQ(test::readText(rawlog()), first);
  ASSERT_EQ(importText("VERTEX_SE2 1 A0 0 0 0\n").code, 0);
  EXPECT_FALSE(fs::exists(truth())) << "of an older import";
}

TEST_F(PyfgImport, ATableOfTheUserIsLeftAlone) {
  test::writeText(truth(), "mine\n");
  const auto o = importText(test::twoRobots(3), "--set pyfg.robot=A");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(test::readText(truth()), "mine\n");
  EXPECT_TRUE(contains(o.text, "left as it is")) << o.text;
}

TEST_F(PyfgImport, WhatWasSkippedIsReported) {
  const auto o =
      importText(test::twoRobots(4) + "EDGE_RANGE 103 A0 L7 nan 1\nFOO\n", "--set pyfg.robot=A");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(contains(o.text, "line_not_finite")) << o.text;
  EXPECT_TRUE(contains(o.text, "g.pyfg:29: `FOO`")) << o.text;
}

TEST_F(PyfgImport, WrongUseAndWrongFiles) {
  const auto unnamed = importText(test::twoRobots(4));
  EXPECT_EQ(unnamed.code, 2);
  EXPECT_TRUE(contains(unnamed.text, "A, B")) << unnamed.text;
  EXPECT_EQ(importText(test::twoRobots(4), "--set pyfg.robot=Z").code, 2);
  EXPECT_EQ(importText(test::twoRobots(4), "--set pyfg.rob=A").code, 2);
  const auto empty = importText("");
  EXPECT_EQ(empty.code, 2);
  EXPECT_TRUE(contains(empty.text, "is empty")) << empty.text;
  EXPECT_EQ(importText("no graph\n").code, 1);
  EXPECT_EQ(import(folder / "none").code, 2);
  EXPECT_EQ(import(folder.path()).code, 1);
  EXPECT_FALSE(fs::exists(rawlog()));
}

TEST_F(PyfgImport, TheSharedGraphs) {
  VIR_REQUIRE_DATA(data, "range_graphs");
  ASSERT_EQ(import(data / "single_drone.pyfg").code, 0);
  EXPECT_EQ(labels(), (Labels{{"GT", 1754}, {"ODOM", 1754}, {"UWB0", 1754}}));
  ASSERT_EQ(import(data / "tiers_AB.pyfg", "--set pyfg.robot=B").code, 0);
  EXPECT_EQ(labels(), (Labels{{"GT", 2440}, {"ODOM", 2442}, {"PEER", 764}, {"UWB0", 551}}));
}

}  // namespace
}  // namespace vir
