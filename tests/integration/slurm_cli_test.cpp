/// vir-slam batch --engine slurm: on a Slurm of one node where there is one, and with tools in its
/// place that fail as a cluster can.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;
namespace fs = std::filesystem;

class SlurmCli : public ::testing::Test {
 protected:
  SlurmCli() {
    test::writeText(folder_ / "world.ini",
                    "[simulator]\ntracks = true\n[Robot_A]\nflight = eight\nduration_s = 6\n");
    test::writeText(folder_ / "run.ini", "[Estimator]\ndriver = vir\nuse_ranges = false\n");
    test::writeText(folder_ / "plan.ini",
                    "[Batch]\nsequences = eight\nconditions = clean\nseeds = 0 1 2\nini = run.ini\n"
                    "settings = off\n[Sequence_eight]\nworld = world.ini\n[Condition_clean]\n"
                    "[Setting_off]\n");
  }

  test::Outcome batch(const std::string& environment, const std::string& more = "") const {
    return test::shell("cd " + quoted(folder_.path().string()) + " && env " + environment + " " +
                       quoted(test::buildDir() + "/bin/vir-slam") +
                       " batch plan.ini --out out --engine slurm " + more);
  }

  /// A tool in the place of Slurm's.
  void tool(const std::string& name, const std::string& script) const {
    const fs::path file = folder_ / "tools" / name;
    fs::create_directories(file.parent_path());
    test::writeText(file, "#!/bin/bash\n" + script);
    fs::permissions(file, fs::perms::owner_all);
  }
  std::string tools() const { return "PATH=" + quoted((folder_ / "tools").string()) + ":$PATH"; }

  /// sbatch that runs each task at once, but for those that `lose` (a condition of bash) loses.
  void sbatchThatLoses(const std::string& lose) const {
    tool("sbatch",
         "here=$(dirname \"$0\")\necho call >>\"$here/calls\"\ncall=$(wc -l <\"$here/calls\")\n"
         "for word in \"$@\"; do case $word in --array=*) tasks=${word#--array=} ;; esac; done\n"
         "script=${*: -1}\n"
         "for task in ${tasks//,/ }; do\n  if " +
             lose +
             "; then continue; fi\n"
             "  SLURM_ARRAY_TASK_ID=$task sh \"$script\" >>\"$here/log\" 2>&1\ndone\n"
             "echo \"4$call;cluster\"\n");
    tool("squeue", "exit 0\n");
  }
  long calls() const {
    const std::string text = test::readText(folder_ / "tools/calls");
    return std::count(text.begin(), text.end(), '\n');
  }

  test::TempFolder folder_;
};

TEST_F(SlurmCli, ARealOneDoesEverythingOnce) {
  for (const char* needed : {"slurmctld", "slurmd", "munged", "sbatch"}) {
    const bool there = test::shell("command -v " + std::string(needed)).code == 0;
    if (!there || geteuid() != 0) {
      GTEST_SKIP() << needed << " is not here (slurmctld slurmd slurm-client munge), or not root";
    }
  }
  const std::string node = quoted(test::sourceDir() + "/tests/support/slurm_node.sh");
  const std::string home = quoted((folder_ / "slurm").string());
  const std::string port = std::to_string(20000 + 2 * (getpid() % 5000));
  const test::Outcome started = test::shell(node + " " + home + " " + port);
  if (!contains(started.text, "ready")) {
    test::shell(node + " stop " + home);
    GTEST_SKIP() << "Slurm does not start on this machine: " << started.text.substr(0, 500);
  }
  const std::string here = "SLURM_CONF=" + quoted((folder_ / "slurm/slurm.conf").string());
  const test::Outcome first = batch(here, "--jobs 2");
  const test::Outcome again = batch(here, "--jobs 2");
  test::shell(node + " stop " + home);
  EXPECT_EQ(first.code, 0) << first.text;
  EXPECT_TRUE(contains(first.text, ": 2 tasks, logs in ")) << first.text;
  EXPECT_TRUE(contains(first.text, "3 runs done, 0 were done before, 0 failed")) << first.text;
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_TRUE(contains(again.text, "0 runs done, 3 were done before, 0 failed")) << again.text;
  EXPECT_FALSE(contains(again.text, "tasks, logs in")) << again.text;
  EXPECT_TRUE(contains(test::readText(folder_ / "out/table.csv"), "eight-clean-2"));
}

TEST_F(SlurmCli, WhatATaskHasNotDoneIsGivenOutAgain) {
  sbatchThatLoses("[ $call = 1 ] && [ $task != 2 ]");
  const test::Outcome outcome = batch(tools());
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "job 41 of Slurm: 3 tasks")) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "job 42 of Slurm: 2 tasks")) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "3 runs done, 0 were done before, 0 failed")) << outcome.text;
}

TEST_F(SlurmCli, ATaskThatNeverWorksIsAFailureAfterThreeTries) {
  sbatchThatLoses("[ $task = 3 ]");
  const test::Outcome outcome = batch(tools());
  EXPECT_EQ(outcome.code, 1) << outcome.text;
  EXPECT_EQ(calls(), 3);
  EXPECT_TRUE(contains(outcome.text, "2 runs done, 0 were done before, 1 failed")) << outcome.text;
}

TEST_F(SlurmCli, WhatTheSchedulerRefusesIsSaid) {
  tool("sbatch", "echo 'sbatch: error: invalid partition specified: fast' >&2\nexit 1\n");
  const test::Outcome refused = batch(tools(), "--slurm-options=--partition=fast");
  EXPECT_EQ(refused.code, 1);
  EXPECT_TRUE(contains(refused.text, "invalid partition specified: fast")) << refused.text;
  tool("sbatch", "exit 127\n");
  const test::Outcome missing = batch(tools());
  EXPECT_EQ(missing.code, 1);
  EXPECT_TRUE(contains(missing.text, "needs a machine that submits to Slurm")) << missing.text;
}

}  // namespace
}  // namespace vir
