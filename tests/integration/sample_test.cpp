/// The recording in rawlog/, as scripts/demo.sh runs it. Measured when this was written: see the
/// lines it prints.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "end_to_end.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

class Sample : public testing::TestWithParam<const char*> {};

TEST_P(Sample, RangesHelp) {
  const std::string rawlog = test::sourceDir() + "/rawlog/" + GetParam() + ".rawlog";
  ASSERT_TRUE(std::filesystem::exists(rawlog)) << "rawlog/README.md says how it is made";
  const test::TempFolder folder;
  const test::RunResult with = test::runVir(rawlog, (folder / "with").string());
  const test::RunResult without =
      test::runVir(rawlog, (folder / "without").string(), "--set Estimator.use_ranges=false");
  ASSERT_EQ(with.outcome.code, 0) << with.outcome.text;
  ASSERT_EQ(without.outcome.code, 0) << without.outcome.text;
  const double a = with.summary["ate_posyaw_m"], b = without.summary["ate_posyaw_m"];
  std::printf("%s: ATE with ranges %.3f m, without %.3f m\n", GetParam(), a, b);
  // Where the odometry drifts, they help; where it does not (two_B), they cost next to nothing.
  EXPECT_LT(a, std::max(b, 0.04));
  EXPECT_LT(a, 0.15);
  EXPECT_EQ(with.summary["resets"], 0) << "the dark phase is bridged";
  ASSERT_EQ(with.summary["anchors"].size(), 1u);
  EXPECT_LT(with.summary["anchors"][0]["error"], 0.4);
}

INSTANTIATE_TEST_SUITE_P(TwoRobots, Sample, testing::Values("two_A", "two_B"));

}  // namespace
}  // namespace vir
