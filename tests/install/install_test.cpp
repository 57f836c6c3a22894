/// The install tree as others use it: as a program, as libraries, for plugins of their own.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <vector>

#include "install_tree.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::Outcome;
using test::quoted;

std::string sample() { return test::sourceDir() + "/rawlog/two_A"; }

/// Lines of numbers; the first line that is something else ends them.
std::vector<std::vector<double>> numbers(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::vector<double> row;
    for (double v = 0; words >> v;) row.push_back(v);
    if (!words.eof()) break;
    rows.push_back(row);
  }
  return rows;
}

/// A project that does nothing but look for the components.
Outcome look(const fs::path& folder, const std::string& components) {
  test::writeText(folder / "CMakeLists.txt",
                  "cmake_minimum_required(VERSION 3.22)\nproject(look CXX)\n"
                  "find_package(vir-slam 0.1 REQUIRED COMPONENTS " +
                      components + ")\nmessage(STATUS \"mrpt: ${mrpt-obs_FOUND}.\")\n");
  return test::configure(folder.string(), folder / "build");
}

TEST(Install, ProgramFindsItsPluginsAndSettings) {
  const Outcome plugins = test::installedVirSlam("plugins");
  ASSERT_EQ(plugins.code, 0) << plugins.text;
  for (const char* name : {"vir", "odometry", "euroc", "nlopt", "uwb"}) {
    EXPECT_TRUE(contains(plugins.text, name)) << name << " is missing in\n" << plugins.text;
  }
  for (const char* file : {"share/vir-slam/ini/euroc.ini", "share/doc/vir-slam/README.md",
                           "share/doc/vir-slam/examples/library/CMakeLists.txt"}) {
    EXPECT_TRUE(fs::exists(test::installTree() / file)) << file;
  }
}

TEST(Install, LibraryGivesThePosesOfTheProgram) {
  const test::TempFolder folder;
  test::buildExample("library", folder / "build");
  const Outcome printed =
      test::shell(quoted((folder / "build/print_poses").string()) + " " +
                  quoted(sample() + ".rawlog") + " " + quoted(sample() + ".ini"));
  ASSERT_EQ(printed.code, 0) << printed.text;
  const Outcome run = test::installedVirSlam(
      "run " + quoted((test::installTree() / "share/vir-slam/ini/euroc.ini").string()) +
      " --rawlog " + quoted(sample() + ".rawlog") + " --out " + quoted((folder / "run").string()));
  ASSERT_EQ(run.code, 0) << run.text;

  const auto library = numbers(printed.text);
  const auto program = numbers(test::readText(folder / "run/trajectory.tum"));
  ASSERT_GT(program.size(), 200u);
  ASSERT_EQ(library.size(), program.size()) << printed.text.substr(0, 500);
  for (std::size_t i = 0; i < program.size(); ++i) {
    ASSERT_EQ(library[i].size(), 8u);
    for (std::size_t k = 0; k < 8; ++k) {
      ASSERT_NEAR(library[i][k], program[i][k], 1e-6) << "pose " << i << ", column " << k;
    }
  }
}

TEST(Install, SensorPluginIsImportedFrom) {
  const test::TempFolder folder;
  test::buildExample("sensor_plugin", folder / "build");
  test::writeText(folder / "ranges.csv",
                  "# t_s,anchor,range_m\n10.00,7,3.25\n10.10,7,3.50\n10.20,8,-1\n10.30,8,4.75\n");
  const std::string rawlog = (folder / "ranges.rawlog").string();
  const std::string program = "--plugin-dir " + quoted((folder / "build").string());
  const Outcome imported =
      test::installedVirSlam(program + " import range_table " +
                             quoted((folder / "ranges.csv").string()) + " --out " + quoted(rawlog));
  ASSERT_EQ(imported.code, 0) << imported.text;
  EXPECT_TRUE(contains(imported.text, "1 of 5 lines")) << imported.text;
  const Outcome exported = test::installedVirSlam(
      "export " + quoted(rawlog) + " --format csv --out " + quoted((folder / "csv").string()));
  ASSERT_EQ(exported.code, 0) << exported.text;
  std::string table;
  for (const auto& item : fs::directory_iterator(folder / "csv")) {
    table += test::readText(item.path());
  }
  for (const char* value : {"3.25", "3.5", "4.75"}) {
    EXPECT_TRUE(contains(table, value)) << value << " is missing in\n" << table;
  }
}

TEST(Install, EstimatorPluginIsRun) {
  const test::TempFolder folder;
  test::buildExample("estimator_plugin", folder / "build");
  const Outcome run = test::installedVirSlam(
      "--plugin-dir " + quoted((folder / "build").string()) + " run " +
      quoted(test::sourceDir() + "/examples/estimator_plugin/inertial.ini") + " --rawlog " +
      quoted(sample() + ".rawlog") + " --out " + quoted((folder / "out").string()));
  ASSERT_EQ(run.code, 0) << run.text;
  const auto poses = numbers(test::readText(folder / "out/trajectory.tum"));
  ASSERT_GT(poses.size(), 200u);
  // What it is told to do, and nothing else: at the origin when the rest is over.
  EXPECT_NEAR(std::hypot(poses[0][1], poses[0][2], poses[0][3]), 0, 0.05);
}

TEST(Install, UnknownComponentIsRefusedWithTheList) {
  const test::TempFolder folder;
  const Outcome outcome = look(folder.path(), "evaluation nonsense");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.text, "no component 'nonsense'")) << outcome.text;
  for (const char* known : {"vio", "evaluation", "rawlog", "team", "plugin"}) {
    EXPECT_TRUE(contains(outcome.text, known)) << outcome.text;
  }
}

TEST(Install, OnlyWhatAComponentNeedsIsLookedFor) {
  const test::TempFolder folder;
  const Outcome evaluation = look(folder / "evaluation", "evaluation");
  EXPECT_EQ(evaluation.code, 0) << evaluation.text;
  EXPECT_TRUE(contains(evaluation.text, "mrpt: .")) << evaluation.text;
  const Outcome rawlog = look(folder / "rawlog", "rawlog");
  EXPECT_EQ(rawlog.code, 0) << rawlog.text;
  EXPECT_TRUE(contains(rawlog.text, "mrpt: 1.")) << rawlog.text;
}

}  // namespace
}  // namespace vir
