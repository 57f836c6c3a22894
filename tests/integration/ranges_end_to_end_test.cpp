/// Ranges from a recording to anchors and a better trajectory, with the program as a user calls it.
/// Measured when this was written: rendered flight 0.006 m, its anchor 0.04 m; the real drone 0.47
/// m causal, 0.34 m smoothed, its anchor 0.24 m off horizontally.
#include <gtest/gtest.h>

#include <cmath>

#include "end_to_end.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::quoted;

const nlohmann::json& onlyAnchor(const nlohmann::json& summary) {
  EXPECT_EQ(summary["anchors"].size(), 1u);
  return summary["anchors"][0];
}

long linesOf(const std::string& file) {
  std::ifstream in(file);
  return std::count(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>(), '\n');
}

TEST(RangesEndToEnd, RenderedFlightFindsItsAnchor) {
  VIR_REQUIRE_DATA(recording, test::kRendered);
  const test::TempFolder folder;
  const std::string rawlog = (folder / "a.rawlog").string();
  ASSERT_EQ(test::importEuroc(recording.string(), rawlog).code, 0);
  const test::RunResult r = test::runVir(rawlog, (folder / "out").string());
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_LE(r.summary["ate_posyaw_m"], 0.010);
  const nlohmann::json& anchor = onlyAnchor(r.summary);
  EXPECT_EQ(anchor["state"], "estimated") << "the flight is not planar";
  EXPECT_LE(anchor["error"], 0.10);
  EXPECT_GT(anchor["ranges_used"], 500);
  EXPECT_EQ(test::notFinite(r.folder), "");
  EXPECT_EQ(linesOf(r.folder + "/trajectory_covariance.csv"),
            static_cast<long>(r.trajectory.size()) + 1);
  EXPECT_GT(linesOf(r.folder + "/ranges.csv"), 600);
  EXPECT_EQ(linesOf(r.folder + "/anchors.csv"), 2);
  EXPECT_TRUE(fs::exists(r.folder + "/report.html"));
}

TEST(RangesEndToEnd, OdometryOfARealDrone) {
  VIR_REQUIRE_DATA(graph, "range_graphs/single_drone.pyfg");
  const test::TempFolder folder;
  const std::string rawlog = (folder / "a.rawlog").string();
  const test::Outcome import = test::virSlam("import pyfg " + quoted(graph.string()) + " --out " +
                                             quoted(rawlog) + " --set pyfg.robot=A");
  ASSERT_EQ(import.code, 0) << import.text;
  const std::string run = "run " + quoted(test::sourceDir() + "/ini/odometry_range.ini") +
                          " --rawlog " + quoted(rawlog) + " --out ";
  const std::string with = (folder / "with").string(), without = (folder / "without").string();
  ASSERT_EQ(test::virSlam(run + quoted(with)).code, 0);
  ASSERT_EQ(test::virSlam(run + quoted(without) + " --set Estimator.use_ranges=false").code, 0);
  const auto a = nlohmann::json::parse(test::readText(with + "/summary.json"));
  const auto b = nlohmann::json::parse(test::readText(without + "/summary.json"));
  EXPECT_GT(b["ate_posyaw_m"], 0.9) << "dead reckoning";
  EXPECT_LE(a["ate_posyaw_m"], 0.50);
  EXPECT_LE(a["ate_smoothed_posyaw_m"], 0.40);
  const nlohmann::json& anchor = onlyAnchor(a);
  EXPECT_LE(anchor["error_horizontal"], 0.30);
  const double height_sigma = anchor["sigma"][2];
  const double height_error = std::sqrt(std::pow(anchor["error"].get<double>(), 2) -
                                        std::pow(anchor["error_horizontal"].get<double>(), 2));
  EXPECT_GT(height_sigma, 0.4) << "its height is hardly observable";
  EXPECT_LT(height_error, 3 * height_sigma);
  EXPECT_TRUE(b["anchors"].empty());
}

}  // namespace
}  // namespace vir
