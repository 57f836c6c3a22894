/// From settings of a made-up world to a trajectory, with the program as a user calls it. Measured
/// when this was written: 0.02 m with images of 14 s, 0.12 m with tracks of 28 s, 2.5 s of them
/// dark (0.19 m without ranges).
#include <gtest/gtest.h>

#include "end_to_end.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

using test::quoted;

const std::string kIni = test::sourceDir() + "/ini/simulate_two_robots.ini";

test::RunResult simulateAndRun(const test::TempFolder& folder, const std::string& more) {
  const std::string rawlog = (folder / "a.rawlog").string();
  const test::Outcome made = test::virSlam("simulate " + quoted(kIni) + " --out " + quoted(rawlog) +
                                           " --set simulator.robot=A " + more);
  EXPECT_EQ(made.code, 0) << made.text;
  return test::runVir(rawlog, (folder / "out").string());
}

TEST(SimulateEndToEnd, Images) {
  const test::TempFolder folder;
  const test::RunResult r = simulateAndRun(folder, "--set Robot_A.duration_s=14");
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_EQ(r.summary["frames"], 280);
  EXPECT_GT(r.trajectory.size(), 260u);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_LE(r.summary["ate_posyaw_m"], 0.06);
  EXPECT_EQ(r.summary["anchors"].size(), 1u);
}

/// A flight of tracks and the run on it, for all cases.
struct Tracks {
  test::TempFolder folder;
  test::RunResult run = simulateAndRun(folder, "--set simulator.tracks=true");
};
const Tracks& tracks() {
  static const Tracks made;
  return made;
}

TEST(SimulateEndToEnd, TracksWithoutImages) {
  const test::RunResult& r = tracks().run;
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_EQ(r.summary["frames"], 560);
  EXPECT_GT(r.trajectory.size(), 540u);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_EQ(r.counter("features_unusable"), 0);
  EXPECT_LE(r.summary["ate_posyaw_m"], 0.25);
  EXPECT_LE(r.summary["anchors"][0]["error"], 0.4);
  EXPECT_TRUE(r.warns("there are no features")) << r.summary["warnings"];
}

TEST(SimulateEndToEnd, StartOffsetCountsFromTheFirstTracks) {
  const test::RunResult& whole = tracks().run;
  const test::TempFolder folder;
  const test::RunResult later =
      test::runVir((tracks().folder / "a.rawlog").string(), (folder / "later").string(),
                   "--set Estimator.start_offset_s=10");
  ASSERT_EQ(later.outcome.code, 0) << later.outcome.text;
  EXPECT_EQ(later.summary["frames"].get<int>(), whole.summary["frames"].get<int>() - 200);
}

}  // namespace
}  // namespace vir
