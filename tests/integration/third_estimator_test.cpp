/// An estimator that nobody knew of when the program was built: `driver = auto` finds it by what it
/// says that it takes, and run, record and batch use it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;
namespace fs = std::filesystem;

class ThirdEstimator : public ::testing::Test {
 protected:
  void SetUp() override {
    // The program's own plugins and the new one, side by side.
    fs::create_directories(folder_ / "plugins");
    for (const char* from : {"/lib/vir-slam/plugins", "/tests/fixtures/teleporter"}) {
      for (const auto& file : fs::directory_iterator(test::buildDir() + from)) {
        fs::create_symlink(file.path(), folder_ / "plugins" / file.path().filename());
      }
    }
    test::writeText(folder_ / "world.ini",
                    "[simulator]\ntracks = true\nodometry = true\n"
                    "[Robot_A]\nflight = eight\nduration_s = 6\n"
                    "[SimulatedRanges]\nanchor_m = 3 2 2\n");
    test::writeText(folder_ / "run.ini", "[Teleporter]\nheight_m = 5\n");
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  test::Outcome virSlam(const std::string& arguments) const {
    return test::virSlam("--plugin-dir " + quoted(path("plugins")) + " " + arguments);
  }
  void simulate() const {
    const test::Outcome made =
        virSlam("simulate " + quoted(path("world.ini")) + " --out " + quoted(path("a.rawlog")));
    ASSERT_EQ(made.code, 0) << made.text;
  }
  nlohmann::json summary(const std::string& out) const {
    std::ifstream in(path(out + "/summary.json"));
    return nlohmann::json::parse(in, nullptr, false);
  }

  test::TempFolder folder_;
};

TEST_F(ThirdEstimator, IsFoundByRun) {
  simulate();
  const test::Outcome run = virSlam("run " + quoted(path("run.ini")) + " --rawlog " +
                                    quoted(path("a.rawlog")) + " --out " + quoted(path("out")));
  ASSERT_EQ(run.code, 0) << run.text;
  EXPECT_EQ(summary("out")["estimator"], "teleporter");
  EXPECT_GT(summary("out")["poses"], 50);
  EXPECT_TRUE(contains(test::readText(path("out/used.ini")), "height_m = 5"));
  // Who is named is taken, whatever else there is.
  const test::Outcome named =
      virSlam("run " + quoted(path("run.ini")) + " --rawlog " + quoted(path("a.rawlog")) +
              " --out " + quoted(path("named")) + " --set Estimator.driver=odometry");
  EXPECT_EQ(named.code, 2) << "[Teleporter] is nobody's then";
}

TEST_F(ThirdEstimator, IsFoundByBatch) {
  test::writeText(folder_ / "plan.ini",
                  "[Batch]\nsequences = eight\nconditions = clean\nseeds = 0\nini = run.ini\n"
                  "settings = plain\n[Sequence_eight]\nworld = world.ini\n[Condition_clean]\n"
                  "[Setting_plain]\n");
  const test::Outcome batch =
      virSlam("batch " + quoted(path("plan.ini")) + " --out " + quoted(path("batch")));
  ASSERT_EQ(batch.code, 0) << batch.text;
  EXPECT_EQ(summary("batch/runs/eight-clean-0/plain")["estimator"], "teleporter");
  EXPECT_TRUE(contains(test::readText(path("batch/table.csv")), "plain"));
  EXPECT_TRUE(contains(batch.text, "1 of 1") || contains(batch.text, "done")) << batch.text;
}

TEST_F(ThirdEstimator, OnlyWhatTheEstimatorTakesCountsAsFrames) {
  simulate();
  const test::Outcome run = virSlam(
      "run " + quoted(std::string(test::sourceDir()) + "/ini/euroc.ini") + " --rawlog " +
      quoted(path("a.rawlog")) + " --out " + quoted(path("run")) + " --set Estimator.driver=vir");
  ASSERT_EQ(run.code, 0) << run.text;
  test::writeText(folder_ / "live.ini",
                  "[Recording]\nestimate = true\n[Estimator]\ndriver = vir\n"
                  "[replay]\ndriver = RawlogReplay\nprocess_rate = 200\nrawlog = a.rawlog\n"
                  "labels = TRACKS0 UWB0 ODOM GT IMU0\nclock = keep\n");
  const test::Outcome record =
      virSlam("record " + quoted(path("live.ini")) + " --out " + quoted(path("live.rawlog")) +
              " --results " + quoted(path("live")));
  ASSERT_EQ(record.code, 0) << record.text;
  // The odometry that is recorded beside the images makes none.
  const nlohmann::json live = summary("live");
  EXPECT_EQ(live["frames"].get<long>() + live["counters"]["images_dropped_late"].get<long>(),
            summary("run")["frames"].get<long>());
}

TEST_F(ThirdEstimator, IsFoundByRecord) {
  simulate();
  test::writeText(folder_ / "live.ini",
                  "[Recording]\nestimate = true\n[Teleporter]\nheight_m = 5\n"
                  "[replay]\ndriver = RawlogReplay\nprocess_rate = 200\nrawlog = a.rawlog\n"
                  "labels = TRACKS0 UWB0 ODOM GT IMU0\nclock = keep\nspeed = 4\n");
  const test::Outcome record =
      virSlam("record " + quoted(path("live.ini")) + " --out " + quoted(path("live.rawlog")) +
              " --results " + quoted(path("live")));
  ASSERT_EQ(record.code, 0) << record.text;
  EXPECT_EQ(summary("live")["estimator"], "teleporter");
  EXPECT_GT(summary("live")["poses"], 50);
}

}  // namespace
}  // namespace vir
