#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "vir/results/results_folder.h"
#include "vir/results/run_recorder.h"
#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

namespace fs = std::filesystem;

TEST(ResultsFolder, OldResultsDoNotSurviveButOtherFilesDo) {
  const test::TempFolder folder;
  test::writeText(folder / "r/trajectory.tum", "old");
  test::writeText(folder / "r/notes.txt", "mine");
  const ResultsFolder results((folder / "r").string());
  EXPECT_FALSE(fs::exists(results.file("trajectory.tum")));
  EXPECT_TRUE(fs::exists(results.file("notes.txt")));
}

TEST(ResultsFolder, DatedFolderAndLatest) {
  const test::TempFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  const ResultsFolder first("");
  const ResultsFolder second("");
  EXPECT_NE(first.path(), second.path());
  EXPECT_EQ(fs::canonical("results/latest"), fs::canonical(second.path()));
  fs::current_path(before);
}

TEST(ResultsFolder, CannotBeMade) {
  const test::TempFolder folder;
  test::writeText(folder / "file", "x");
  EXPECT_THROW(ResultsFolder((folder / "file").string()), std::runtime_error);
  EXPECT_THROW(ResultsFolder((folder / "file/deeper").string()), std::runtime_error);
}

TEST(OutputFile, FullDiskIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(writeTextFile("/dev/full", "text"), std::runtime_error);
  EXPECT_THROW(OutputFile("/nowhere/x"), std::runtime_error);
}

TEST(OutputFile, HasItsNameOnlyWhenItIsComplete) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.csv").string();
  test::writeText(path, "old");
  {
    OutputFile file(path);
    file.line("new");
    EXPECT_EQ(test::readText(path), "old");
    file.close();
  }
  EXPECT_EQ(test::readText(path), "new\n");
  EXPECT_FALSE(fs::exists(path + ".part"));
  { OutputFile(path).line("never closed"); }
  EXPECT_EQ(test::readText(path), "new\n");
  OutputFile log((folder / "run.log").string(), OutputFile::Named::at_once);
  EXPECT_TRUE(fs::exists(folder / "run.log"));
}

TEST(OutputFile, WritesThroughALinkToWhatItLeadsTo) {
  const test::TempFolder folder;
  test::writeText(folder / "real.json", "old");
  fs::create_symlink("real.json", folder / "link.json");
  writeTextFile((folder / "link.json").string(), "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.json"));
  EXPECT_EQ(test::readText(folder / "real.json"), "new");
}

/// What an earlier run that was killed left behind, and what it made with other settings.
TEST(ResultsFolder, LeavesNothingOfAnEarlierRun) {
  const test::TempFolder folder;
  for (const char* name : {"calibration.yaml", "trajectory.tum.part", "summary.json.part"}) {
    test::writeText(folder / "r" / name, "old");
  }
  const ResultsFolder results((folder / "r").string());
  EXPECT_TRUE(fs::is_empty(folder / "r"));
}

TEST(Summary, HasTheFixedKeysAndNoNan) {
  RunSummary s;
  s.frames = 3;
  s.ate_posyaw_m = std::nan("");
  s.rawlog = "\xff\xfe";
  s.counters = {{"late_IMU0", 2}};
  const auto json = nlohmann::json::parse(toJson(s));
  for (const char* key :
       {"frames", "init_time_s", "duration_s", "wall_s", "cpu_s", "cpu_ms_per_frame", "peak_rss_mb",
        "anchors", "resets", "warnings", "counters", "longest_wait_reason", "poses"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_TRUE(json["init_time_s"].is_null());
  EXPECT_FALSE(json.contains("ate_posyaw_m"));
  EXPECT_EQ(json["counters"]["late_IMU0"], 2);
}

}  // namespace
}  // namespace vir::results
