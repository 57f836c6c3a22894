/// An uncalibrated UWB board, half a metre too long, on a simulated flight: the anchor is found
/// where it is and the flight costs nothing; an exact board is taken as such.
#include <gtest/gtest.h>

#include <cmath>

#include "end_to_end.h"

namespace vir {
namespace {

using test::quoted;

test::RunResult flight(const test::TempFolder& folder, int seed, double bias_m) {
  const std::string name = std::to_string(seed) + "_" + std::to_string(bias_m);
  const std::string rawlog = (folder / (name + ".rawlog")).string();
  const test::Outcome made = test::virSlam(
      "simulate " + quoted(test::sourceDir() + "/ini/simulate_benchmark.ini") + " --out " +
      quoted(rawlog) + " --set Flight.length_m=60 --set simulator.seed=" + std::to_string(seed) +
      " --set SimulatedRanges.bias_m=" + std::to_string(bias_m));
  EXPECT_EQ(made.code, 0) << made.text;
  return test::runVir(rawlog, (folder / name).string());
}

TEST(UncalibratedBoard, HalfAMetreTooLongIsTold) {
  const test::TempFolder folder;
  // Six seeds: ATE 0.048 m with 0.6 m of bias and 0.047 without, anchor off by 0.05 to 0.25 m and
  // 0.01 to 0.18 m.
  for (const int seed : {1, 2}) {
    const test::RunResult exact = flight(folder, seed, 0), biased = flight(folder, seed, 0.6);
    ASSERT_EQ(exact.outcome.code, 0) << exact.outcome.text;
    ASSERT_EQ(biased.outcome.code, 0) << biased.outcome.text;
    const auto& anchor = biased.summary["anchors"][0];
    EXPECT_LT(anchor["error"], 0.25) << "seed " << seed << " " << anchor;
    EXPECT_NEAR(anchor["bias"].get<double>(), 0.6, 0.15) << "seed " << seed;
    EXPECT_TRUE(biased.warns("an uncalibrated board")) << biased.summary["warnings"];
    EXPECT_LT(biased.summary["ate_posyaw_m"],
              1.2 * exact.summary["ate_posyaw_m"].get<double>() + 0.01)
        << "seed " << seed;
    const auto& held = exact.summary["anchors"][0];
    EXPECT_LT(held["error"], 0.15) << "seed " << seed << " " << held;
    EXPECT_LT(std::abs(held["bias"].get<double>()), 0.06) << held;
    EXPECT_LE(held["bias_sigma"], 0.031) << "a calibrated board's prior holds it";
    EXPECT_FALSE(exact.warns("uncalibrated"));
  }
}

}  // namespace
}  // namespace vir
