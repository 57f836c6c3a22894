/// `vir-slam run` and `plugins` as a user calls them: exit codes, messages, files.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "vir_test_paths.h"
#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::Outcome;
using test::quoted;
using test::virSlam;

const std::string kPlugins = " --plugin-dir " + test::buildDir() + "/tests/fixtures/good ";

class RunCli : public testing::Test {
 protected:
  void SetUp() override {
    test::writeRecording(path("a b.rawlog"), 30);  // with a blank in the name
    test::writeText(path("c.ini"), "[Estimator]\ndriver = counting\n");
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  Outcome run(const std::string& more) {
    return virSlam(kPlugins + "run " + quoted(path("c.ini")) + " --out " + quoted(path("out")) +
                   " " + more);
  }
  std::string withRawlog() const { return "--rawlog " + quoted(path("a b.rawlog")) + " "; }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }

  test::TempFolder folder_;
};

TEST_F(RunCli, WritesItsFilesAndSaysWhere) {
  const Outcome outcome = run(withRawlog());
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "Results in " + path("out"))) << outcome.text;
  EXPECT_FALSE(contains(outcome.text, "\r")) << "a progress bar without a terminal";
  for (const char* name :
       {"trajectory.tum", "trajectory_covariance.csv", "trajectory_smoothed.tum", "frames.csv",
        "anchors.csv", "ranges.csv", "landmarks.ply", "summary.json", "used.ini", "run.log"}) {
    EXPECT_TRUE(exists("out/" + std::string(name))) << name;
  }
  const auto summary = nlohmann::json::parse(test::readText(path("out/summary.json")));
  EXPECT_EQ(summary["frames"], 30);
  EXPECT_EQ(summary["poses"], 28);
  EXPECT_EQ(summary["estimator"], "counting");
}

TEST_F(RunCli, SaysWhatBecameOfAnchorsAndRanges) {
  {
    rawlog::RawlogWriter writer(path("ranges.rawlog"));
    for (int i = 0; i < 30; ++i) {
      const TimeNs t = test::kStart + 50 * i * test::kMs;
      writer.write(*test::imageAt(t, i));
      writer.write(*test::truthAt(t, 0.1 * i));
      writer.write(*test::rangeAt(t, 4));
      if (i == 0) writer.write(*test::rangeAt(t, 5));
    }
    writer.finish();
  }
  test::writeText(path("ranges_anchors_truth.csv"), "#id,x,y,z\n4,1,6,3.25\nnonsense\n4,1,2,3\n");
  const Outcome outcome = run("--rawlog " + quoted(path("ranges.rawlog")));
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  for (const char* part :
       {"anchors found", "1 of 2", "anchor 4 (estimated)", "1.000 6.000 3.000", "0.250 (0.000)",
        "anchor 5 (collecting)", "anchor 5: move sideways, or up", "ranges used", "ranges rejected",
        "2 lines of "}) {
    EXPECT_TRUE(contains(outcome.text, part)) << part << "\n" << outcome.text;
  }
  const auto summary = nlohmann::json::parse(test::readText(path("out/summary.json")));
  EXPECT_NEAR(summary["anchors"][0]["error"].get<double>(), 0.25, 1e-6);
}

TEST_F(RunCli, UsedIniRunsAgainToTheSameResult) {
  ASSERT_EQ(run(withRawlog() + "--set Estimator.first_pose=5").code, 0);
  const std::string first = test::readText(path("out/trajectory.tum"));
  const Outcome again =
      virSlam(kPlugins + "run " + quoted(path("out/used.ini")) + " --out " + quoted(path("out2")));
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(test::readText(path("out2/trajectory.tum")), first);
}

TEST_F(RunCli, UsedIniRunsAgainWhereverTheRawlogWasNamedFrom) {
  const std::string program = quoted(test::buildDir() + "/bin/vir-slam") + kPlugins;
  const Outcome first = test::shell("cd " + quoted(path("")) + " && " + program +
                                    "run c.ini --rawlog 'a b.rawlog' --out out");
  ASSERT_EQ(first.code, 0) << first.text;
  const Outcome again =
      virSlam(kPlugins + "run " + quoted(path("out/used.ini")) + " --out " + quoted(path("out2")));
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(test::readText(path("out2/trajectory.tum")),
            test::readText(path("out/trajectory.tum")));
}

TEST_F(RunCli, RawlogInTheIniIsRelativeToTheIni) {
  test::writeText(path("d.ini"), "[Estimator]\ndriver = counting\nrawlog = a b.rawlog\n");
  const Outcome outcome =
      virSlam(kPlugins + "run " + quoted(path("d.ini")) + " --out " + quoted(path("out")));
  EXPECT_EQ(outcome.code, 0) << outcome.text;
}

TEST_F(RunCli, NoiseOfTheRecordingUnlessTheUserSaysOtherwise) {
  const std::string mark = "// Written by vir-slam import\n";
  test::writeText(path("a b.ini"), mark + "[Imu]\ngyro_noise_density = 0.5\nother = 1\n");
  ASSERT_EQ(run(withRawlog()).code, 0);
  EXPECT_TRUE(contains(test::readText(path("out/used.ini")), "gyro_noise_density = 0.5"));
  EXPECT_TRUE(contains(test::readText(path("out/run.log")), "taken from"));
  ASSERT_EQ(run(withRawlog() + "--set Imu.gyro_noise_density=0.25").code, 0);
  EXPECT_TRUE(contains(test::readText(path("out/used.ini")), "gyro_noise_density = 0.25"));
  // A file of that name which import did not write is the user's own.
  test::writeText(path("a b.ini"), "[Imu]\ngyro_noise_density = 0.5\n");
  ASSERT_EQ(run(withRawlog()).code, 0);
  EXPECT_FALSE(contains(test::readText(path("out/used.ini")), "gyro_noise_density = 0.5"));
}

TEST_F(RunCli, WrongUseIsTwoAndLeavesNoFolder) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "no recording named"},
      {"--rawlog /nowhere/x.rawlog", "no such rawlog: /nowhere/x.rawlog"},
      {withRawlog() + "--set Estimator.frist_pose=1", "did you mean first_pose?"},
      {withRawlog() + "--set Estimator.first_pose=abc", "not a whole number"},
      {withRawlog() + "--set Estimator.first_pose", "not of the form"},
      {withRawlog() + "--set Estimator.driver=nope", "unknown estimator 'nope'"},
      {withRawlog() + "--set Estimator.start_offset_s=-1", "out of bounds"},
      {withRawlog() + "--set Estimator.create=false", "told not to be made; set create = true"},
      {withRawlog() + "--nonsense", "--nonsense"},
  };
  for (const auto& [arguments, message] : cases) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.text;
    EXPECT_TRUE(contains(outcome.text, message)) << outcome.text;
    EXPECT_FALSE(exists("out")) << arguments;
  }
  EXPECT_EQ(virSlam("run /nowhere.ini").code, 2);
  EXPECT_EQ(virSlam("").code, 2);
  EXPECT_EQ(virSlam("frobnicate").code, 2);
  EXPECT_EQ(virSlam("--plugin-dir /nowhere plugins").code, 2);
}

TEST_F(RunCli, FailedRunIsOne) {
  const Outcome thrown = run(withRawlog() + "--set Estimator.throw_at=10");
  EXPECT_EQ(thrown.code, 1);
  EXPECT_TRUE(contains(thrown.text, "told to throw")) << thrown.text;
  EXPECT_TRUE(exists("out/trajectory.tum"));
  const Outcome none = run(withRawlog() + "--set Estimator.first_pose=100");
  EXPECT_EQ(none.code, 1);
  EXPECT_TRUE(contains(none.text, "no pose at all: waiting, as told")) << none.text;
  test::writeText(path("a b.rawlog"), "this is not a rawlog");
  const Outcome junk = run(withRawlog());
  EXPECT_EQ(junk.code, 1);
  EXPECT_TRUE(contains(junk.text, "damaged or cut off after 0 objects")) << junk.text;
}

TEST_F(RunCli, InterruptKeepsWhatThereIs) {
  test::writeRecording(path("long.rawlog"), 20000);
  const std::string program = quoted(test::buildDir() + "/bin/vir-slam") + kPlugins;
  const Outcome outcome = test::shell(
      program + "run " + quoted(path("c.ini")) + " --rawlog " + quoted(path("long.rawlog")) +
      " --out " + quoted(path("out")) + " & child=$!; while kill -0 $child && [ ! -s " +
      quoted(path("out/trajectory.tum.part")) +
      " ]; do sleep 0.01; done; kill -INT $child; wait $child");
  EXPECT_EQ(outcome.code, 1) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "interrupted")) << outcome.text;
  const auto summary = nlohmann::json::parse(test::readText(path("out/summary.json")));
  EXPECT_EQ(summary["interrupted"], true);
  EXPECT_GT(summary["poses"], 0);
  EXPECT_LT(summary["poses"], 19000);
}

TEST(PluginsCli, ListsAndExplains) {
  const Outcome list = virSlam(kPlugins + "plugins");
  EXPECT_EQ(list.code, 0);
  EXPECT_TRUE(contains(list.text, "counting")) << list.text;
  EXPECT_TRUE(contains(list.text, "ticking")) << list.text;
  const Outcome one = virSlam(kPlugins + "plugins counting");
  EXPECT_EQ(one.code, 0);
  EXPECT_TRUE(contains(one.text, "driver = counting\n")) << one.text;
  EXPECT_TRUE(contains(one.text, "first_pose = 2\n")) << one.text;
  EXPECT_EQ(virSlam(kPlugins + "plugins nope").code, 2);
}

TEST(Help, EveryCommandExplainsItselfWithExamples) {
  EXPECT_EQ(virSlam("--help").text.rfind("Examples:", 0), 0u);
  EXPECT_TRUE(contains(virSlam("--version").text, "vir-slam "));
  for (const std::string command : {"run", "import", "evaluate", "export", "plugins"}) {
    const Outcome outcome = virSlam(command + " --help");
    EXPECT_EQ(outcome.code, 0) << command;
    EXPECT_TRUE(contains(outcome.text, "vir-slam " + command)) << outcome.text;
  }
}

}  // namespace
}  // namespace vir
