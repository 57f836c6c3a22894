/// Whole flights (simulated tracks and readings) whose sensors do not do what they should.
#include <gtest/gtest.h>

#include "looking_ahead.h"

namespace vir::estimator {
namespace {

using tool::RunResult;
using tool::RunSettings;
using tool::simulateRun;
using vir_test::flightOf;
using vir_test::lookingAhead;

/// With the shutter held to be a global one the flights of these seeds are 0.1 to 0.25 m off.
TEST(DisturbedFlight, ARollingShutterIsFoundAndCostsNothing) {
  const auto motion = flightOf("eight", 60);
  double global = 0, rolling = 0, held = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    RunSettings s = lookingAhead();
    const RunResult at_once = simulateRun(motion, s, seed);
    s.tracks.readout_s = 0.02;
    const RunResult found = simulateRun(motion, s, seed);
    s.estimator.window.calibration.readout_s = 1e-6;
    const RunResult not_looked_for = simulateRun(motion, s, seed);
    ASSERT_TRUE(at_once.valid && found.valid && not_looked_for.valid);
    EXPECT_NEAR(at_once.calibration.readout_s, 0, 1e-4) << "seed " << seed;
    EXPECT_NEAR(found.calibration.readout_s, 0.02, 0.001) << "seed " << seed;
    global += at_once.evaluation.ate_position_m.rmse / 3;
    rolling += found.evaluation.ate_position_m.rmse / 3;
    held += not_looked_for.evaluation.ate_position_m.rmse / 3;
  }
  std::printf("ATE: global shutter %.4f m, rolling %.4f m, not looked for %.4f m\n", global,
              rolling, held);
  EXPECT_LT(rolling, 1.3 * global + 0.005);
  EXPECT_GT(held, 1.5 * rolling) << "what the test is about must matter";
}

TEST(DisturbedFlight, TwoSecondsWithoutReadingsAreBridgedByTheImages) {
  const auto motion = flightOf("eight", 60);
  double whole = 0, bridged = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    RunSettings s = lookingAhead();
    const RunResult all = simulateRun(motion, s, seed);
    s.silent_imu_s = {14.0 + seed, 16.0 + seed};
    const RunResult silent = simulateRun(motion, s, seed);
    ASSERT_TRUE(all.valid && silent.valid);
    EXPECT_EQ(silent.resets, 0) << "seed " << seed;
    EXPECT_EQ(silent.estimate.size(), all.estimate.size()) << "a pose for every image";
    whole += all.evaluation.ate_position_m.rmse / 3;
    bridged += silent.evaluation.ate_position_m.rmse / 3;
  }
  std::printf("ATE: %.4f m, with 2 s missing %.4f m\n", whole, bridged);
  EXPECT_LT(bridged, 1.5 * whole + 0.03);
}

}  // namespace
}  // namespace vir::estimator
