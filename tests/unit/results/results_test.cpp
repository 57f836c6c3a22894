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
