/// vir-slam batch: what is run, what is not run again, and what the table says.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;
namespace fs = std::filesystem;

const std::string kWorld =
    "[simulator]\ntracks = true\n[Robot_A]\nflight = eight\nduration_s = 9\n"
    "[SimulatedRanges]\nanchor_m = 3 2 2\n";

std::string plan(const std::string& settings) {
  return "[Batch]\nsequences = eight\nconditions = clean dark\nseeds = 0 1\nini = run.ini\n"
         "settings = " +
         settings +
         "\n[Sequence_eight]\nworld = world.ini\n"
         "[Condition_clean]\n[Condition_dark]\nSimulatedTracks.blackout_s = 6 7\n"
         "[Setting_off]\nEstimator.use_ranges = false\n"
         "[Setting_on]\ntitle = with ranges\n"
         "[Setting_wrong]\nEstimator.no_such_key = 1\n";
}

class BatchCli : public ::testing::Test {
 protected:
  BatchCli() {
    test::writeText(folder_ / "world.ini", kWorld);
    test::writeText(folder_ / "run.ini", "[Estimator]\ndriver = vir\n");
    test::writeText(folder_ / "plan.ini", plan("off on"));
  }
  test::Outcome batch(const std::string& more, const std::string& out = "out") const {
    return test::virSlam("batch " + quoted((folder_ / "plan.ini").string()) + " --out " +
                         quoted((folder_ / out).string()) + " " + more);
  }
  std::vector<std::string> lines(const std::string& file) const {
    std::istringstream in(test::readText(folder_ / file));
    std::vector<std::string> out;
    for (std::string line; std::getline(in, line);) out.push_back(line);
    return out;
  }
  test::TempFolder folder_;
};

std::vector<std::string> cells(const std::string& line, char separator) {
  std::vector<std::string> out;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, separator);) out.push_back(cell);
  return out;
}

TEST_F(BatchCli, RunsEverythingOnceAndTellsTheNumbersOfTheRuns) {
  const test::Outcome first = batch("");
  ASSERT_EQ(first.code, 0) << first.text;
  EXPECT_TRUE(contains(first.text, "8 runs done, 0 were done before, 0 failed")) << first.text;
  const std::vector<std::string> csv = lines("out/table.csv");
  ASSERT_EQ(csv.size(), 9u);
  for (std::size_t i = 1; i < csv.size(); ++i) {
    const std::vector<std::string> c = cells(csv[i], ',');
    const auto summary = nlohmann::json::parse(
        test::readText(folder_ / ("out/runs/" + c[0] + "/" + c[3] + "/summary.json")));
    EXPECT_NEAR(std::stod(c[4]), summary["ate_posyaw_m"].get<double>(), 1e-6) << csv[i];
    EXPECT_NEAR(std::stod(c[7]), summary["rpe_1s_m"].get<double>(), 1e-6) << csv[i];
    EXPECT_NEAR(std::stod(c[10]), summary["nees_position"].get<double>(), 1e-6) << csv[i];
  }
  // The rows hold the mean of two seeds' numbers, which is the median of two.
  const double both = 0.5 * (std::stod(cells(csv[1], ',')[4]) + std::stod(cells(csv[3], ',')[4]));
  const std::vector<std::string> row = cells(lines("out/table.md")[2], '|');
  EXPECT_TRUE(contains(row[2], "eight-clean")) << row[2];
  EXPECT_TRUE(contains(row[4], "2")) << row[4];
  const std::size_t digits = row[5].find_first_of("0123456789");
  EXPECT_NEAR(std::stod(row[5].substr(digits)), both, 6e-4);
  const std::string page = test::readText(folder_ / "out/table.html");
  EXPECT_TRUE(contains(page, "<circle"));
  EXPECT_TRUE(contains(page, "href=\"runs/eight-dark-1/on/report.html\""));
  EXPECT_TRUE(fs::exists(folder_ / "out/runs/eight-dark-1/on/report.html"));
  EXPECT_TRUE(contains(test::readText(folder_ / "out/table.md"), "with ranges"));

  const test::Outcome second = batch("");
  EXPECT_TRUE(contains(second.text, "0 runs done, 8 were done before")) << second.text;
  // What was not finished is done again, and only that.
  fs::remove(folder_ / "out/runs/eight-dark-1/on/batch.json");
  const test::Outcome third = batch("");
  EXPECT_TRUE(contains(third.text, "1 runs done, 7 were done before")) << third.text;
  // Other settings, other results.
  test::writeText(folder_ / "run.ini", "[Estimator]\ndriver = vir\nlong_window_size = 50\n");
  const test::Outcome fourth = batch("--only eight-clean-0/");
  EXPECT_TRUE(contains(fourth.text, "2 runs done, 0 were done before")) << fourth.text;
}

TEST_F(BatchCli, PartsMakeTheSameTableAsTheWhole) {
  ASSERT_EQ(batch("--only eight-clean", "whole").code, 0);
  ASSERT_EQ(batch("--only eight-clean --shard 1/2", "one").code, 0);
  ASSERT_EQ(batch("--only eight-clean --shard 2/2", "two").code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "one/runs/eight-clean-1"));
  EXPECT_FALSE(fs::exists(folder_ / "two/runs/eight-clean-0"));
  const test::Outcome merged = batch("--merge --from " + quoted((folder_ / "one").string()) +
                                         " --from " + quoted((folder_ / "two").string()),
                                     "merged");
  ASSERT_EQ(merged.code, 0) << merged.text;
  const auto withoutTime = [&](const std::string& file) {
    std::string out;
    for (const std::string& line : lines(file)) {
      std::vector<std::string> c = cells(line, ',');
      if (c.size() > 13) c[13] = "";  // CPU
      for (const std::string& cell : c) out += cell + ",";
      out += "\n";
    }
    return out;
  };
  EXPECT_EQ(withoutTime("whole/table.csv"), withoutTime("merged/table.csv"));
  EXPECT_TRUE(contains(test::readText(folder_ / "merged/table.md"), "2 (2 missing)"));
}

TEST_F(BatchCli, AFailureIsCountedAndTheRestGoesOn) {
  test::writeText(folder_ / "plan.ini", plan("wrong on"));
  const test::Outcome outcome = batch("--only eight-clean-0/");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.text, "1 runs done, 0 were done before, 1 failed")) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "eight-clean-0/wrong")) << outcome.text;
  EXPECT_TRUE(
      contains(test::readText(folder_ / "out/runs/eight-clean-0/wrong/batch.log"), "no_such_key"));
  EXPECT_TRUE(contains(test::readText(folder_ / "out/table.html"), "exit code 2"));
}

TEST_F(BatchCli, WhatTakesTooLongIsEnded) {
  const test::Outcome outcome = batch("--only eight-clean-0/on --set Batch.timeout_s=0.2");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.text, "took longer than")) << outcome.text;
}

TEST_F(BatchCli, WrongPlansAreRefusedWithTheLine) {
  const auto refused = [&](const std::string& text, const std::string& why) {
    test::writeText(folder_ / "plan.ini", text);
    const test::Outcome outcome = batch("");
    EXPECT_EQ(outcome.code, 2) << text;
    EXPECT_TRUE(contains(outcome.text, why)) << outcome.text;
  };
  refused("[Batch]\nsettings = on\n", "sequences");
  refused(plan("on off on"), "there twice");
  refused(plan("on none"), "no such section");
  refused(plan("on") + "[Sequenz_x]\nworld = world.ini\n", "unknown section");
  refused(plan("on") + "[Sequence_x]\nworld = none.ini\n[Batch2]\n", "Batch2");
  refused(
      "[Batch]\nsequences = a\nsettings = on\nini = run.ini\nseeds = 1 x\n[Sequence_a]\nworld "
      "= world.ini\n[Setting_on]\n",
      "seeds");
  refused(
      "[Batch]\nsequences = a\nsettings = on\nini = run.ini\n[Sequence_a]\nwelt = 3\n"
      "[Setting_on]\n",
      "either rawlog");
  refused(
      "[Batch]\nsequences = a\nsettings = on\nini = run.ini\n[Sequence_a]\nworld = "
      "world.ini\nwelt = 3\n[Setting_on]\n",
      "unknown here");
  test::writeText(folder_ / "plan.ini", plan("on"));
  EXPECT_EQ(batch("--shard 3/2").code, 2);
  EXPECT_EQ(batch("--shard 0/2").code, 2);
  EXPECT_EQ(batch("--shard 1/2x").code, 2);
  EXPECT_EQ(batch("--only nothing").code, 2);
}

/// A run that writes on beside its rerun is worth nothing.
TEST_F(BatchCli, WhatItStartedEndsWithIt) {
  const test::Outcome out = test::shell(
      quoted(test::buildDir() + "/bin/vir-slam") + " batch " +
      quoted((folder_ / "plan.ini").string()) + " --out " + quoted((folder_ / "killed").string()) +
      " >/dev/null & batch=$!; for i in $(seq 500); do child=$(pgrep -P $batch) && break; sleep "
      "0.01; "
      "done; kill -9 $batch; for i in $(seq 200); do kill -0 $child 2>/dev/null || { echo gone; "
      "break; }; sleep 0.01; done");
  EXPECT_TRUE(contains(out.text, "gone")) << out.text;
}

}  // namespace
}  // namespace vir
