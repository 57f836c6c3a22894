/// What a run writes about ranges and anchors, with a test estimator in place of the real one.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "vir/core/settings.h"
#include "vir/roles/estimator_registry.h"
#include "vir/roles/plugin_loader.h"
#include "vir/runs/offline_run.h"
#include "vir_test_paths.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::runs {
namespace {

using test::kMs;
using test::kStart;

using Table = std::vector<std::vector<std::string>>;

Table cells(const std::string& text) {
  Table table;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    table.emplace_back();
    std::istringstream fields(line + ",");
    for (std::string field; std::getline(fields, field, ',');) table.back().push_back(field);
  }
  return table;
}

class RangeOutputs : public testing::Test {
 protected:
  void SetUp() override {
    roles::loadPlugin(test::buildDir() + "/tests/fixtures/good/libfixture_estimator.so");
    rawlog_ = (folder_ / "a.rawlog").string();
  }

  /// 20 frames; 6 ranges to anchor 4, 2 to anchor 5, 1 to anchor 6.
  void write(bool images) {
    rawlog::RawlogWriter writer(rawlog_);
    for (int i = 0; i < 20; ++i) {
      const TimeNs t = kStart + 50 * i * kMs;
      if (images) writer.write(*test::imageAt(t));
      if (!images) writer.write(*test::odometryAt(t, 0.1 * i));
      writer.write(*test::truthAt(t, 0.1 * i + 7));
      if (i < 6) writer.write(*test::rangeAt(t, 4));
      if (i < 2) writer.write(*test::rangeAt(t, 5));
      if (i < 1) writer.write(*test::rangeAt(t, 6));
    }
    writer.finish();
  }

  results::RunSummary run(const std::map<std::uint64_t, Vec3>& truth = {}) {
    const auto estimator = roles::estimatorSettings("counting");
    const Settings settings;
    SettingsReader reader(settings);
    estimator->describe(reader);
    const results::ResultsFolder results((folder_ / "out").string());
    OfflineRunOptions options;
    options.rawlog = rawlog_;
    options.true_anchors = truth;
    return runOffline(*estimator->create({}), options, results, {});
  }

  Table table(const std::string& name) { return cells(test::readText(folder_ / ("out/" + name))); }

  test::TempFolder folder_;
  std::string rawlog_;
};

TEST_F(RangeOutputs, AnchorsHaveTheFixedColumns) {
  write(true);
  run();
  const Table t = table("anchors.csv");
  ASSERT_EQ(t.size(), 4u);
  const std::vector<std::string> begin{"id",     "x",      "y",      "z",      "cov_xx",
                                       "cov_xy", "cov_xz", "cov_yx", "cov_yy", "cov_yz",
                                       "cov_zx", "cov_zy", "cov_zz", "state"};
  EXPECT_TRUE(std::equal(begin.begin(), begin.end(), t[0].begin()));
  for (const auto& row : t) EXPECT_EQ(row.size(), 22u);
  EXPECT_EQ(std::vector<std::string>(t[1].begin(), t[1].begin() + 18),
            (std::vector<std::string>{"4", "1", "6", "3", "0.04", "0.01", "0", "0.01", "0.09", "0",
                                      "0", "0", "0.16", "estimated", "0.1", "0.05", "5", "1"}));
  EXPECT_EQ(t[1][18], "") << "no mirror image any more";
  EXPECT_EQ(t[2][13], "mirror_open");
  EXPECT_EQ(t[2][20], "-3");
  EXPECT_EQ(t[2][21], "move sideways; or up") << "no comma in a word";
  EXPECT_EQ(t[3][13], "collecting");
  EXPECT_EQ(t[3][1], "") << "no position: none is made up";
  EXPECT_EQ(t[3][4], "");
}

TEST_F(RangeOutputs, EveryRangeIsListed) {
  write(true);
  const results::RunSummary s = run();
  const Table t = table("ranges.csv");
  ASSERT_EQ(t.size(), 10u);
  EXPECT_EQ(t[0], (std::vector<std::string>{"t_s", "id", "measured_m", "predicted_m", "residual_m",
                                            "sigma_m", "weight", "decision", "reference"}));
  EXPECT_EQ(t[1], (std::vector<std::string>{"1700000000.000000000", "4", "3", "", "", "", "0",
                                            "collected", ""}));
  EXPECT_EQ(t[4], (std::vector<std::string>{"1700000000.050000000", "4", "3", "2.98", "0.02", "0.1",
                                            "1", "accepted", ""}));
  EXPECT_EQ(t[7][7], "too_long");
  EXPECT_EQ(s.ranges_accepted, 5);
  EXPECT_EQ(s.ranges_collected, 3);
  EXPECT_EQ(s.ranges_rejected, 1);
  std::map<std::string, long> counters(s.counters.begin(), s.counters.end());
  EXPECT_EQ(counters["ranges_accepted"], 5);
  EXPECT_EQ(counters["ranges_collected"], 3);
  EXPECT_EQ(counters["ranges_too_long"], 1);
}

TEST_F(RangeOutputs, CovarianceOfEveryPose) {
  write(true);
  const results::RunSummary s = run();
  const Table t = table("trajectory_covariance.csv");
  ASSERT_EQ(t.size(), static_cast<std::size_t>(s.poses) + 1);
  for (const auto& row : t) ASSERT_EQ(row.size(), 22u);
  EXPECT_EQ(t[1][0], "1700000000.100000000");
  EXPECT_EQ(t[0][6], "px_rz");
  EXPECT_EQ(t[1][6], "0.0001");
  EXPECT_EQ(t[0][7], "py_py");
  EXPECT_EQ(t[1][7], "0.02");
  EXPECT_EQ(t[1][21], "0.0003");
}

TEST_F(RangeOutputs, SummaryNamesTheAnchors) {
  write(true);
  const auto json = nlohmann::json::parse(results::toJson(run()));
  ASSERT_EQ(json["anchors"].size(), 3u);
  const auto& a = json["anchors"][0];
  EXPECT_EQ(a["id"], 4);
  EXPECT_EQ(a["state"], "estimated");
  EXPECT_EQ(a["p"], (nlohmann::json{1.0, 6.0, 3.0}));
  EXPECT_EQ(a["sigma"], (nlohmann::json{0.2, 0.3, 0.4}));
  EXPECT_EQ(a["ranges_used"], 5);
  EXPECT_FALSE(a.contains("error")) << "the truth is not known";
  EXPECT_TRUE(json["anchors"][2]["p"].is_null());
  EXPECT_EQ(json["ranges"]["rejected"], 1);
  EXPECT_EQ(json["ranges"]["before_start"], 0);
}

TEST_F(RangeOutputs, AnchorsAreComparedWhereTheTruthIsKnown) {
  write(true);
  // The estimate's world is 7 m behind the truth's along x.
  const results::RunSummary s = run({{4, Vec3(8, 6.3, 3.4)}, {6, Vec3(0, 0, 0)}});
  ASSERT_EQ(s.anchors.size(), 3u);
  ASSERT_TRUE(s.anchors[0].error_m);
  EXPECT_NEAR(*s.anchors[0].error_m, 0.5, 1e-9);
  EXPECT_NEAR(*s.anchors[0].error_horizontal_m, 0.3, 1e-9);
  EXPECT_FALSE(s.anchors[1].error_m) << "no truth";
  EXPECT_FALSE(s.anchors[2].error_m) << "no position";
}

TEST_F(RangeOutputs, ARunOnOdometryCountsItsPoses) {
  write(false);
  const results::RunSummary s = run();
  EXPECT_EQ(s.frames, 20);
  EXPECT_EQ(s.poses, 18);
  EXPECT_DOUBLE_EQ(s.duration_s, 19 * 0.05);
  ASSERT_TRUE(s.init_time_s);
  EXPECT_DOUBLE_EQ(*s.init_time_s, 0.1);
  EXPECT_TRUE(s.warnings.empty());
  ASSERT_TRUE(s.ate_posyaw_m);
  EXPECT_LT(*s.ate_posyaw_m, 1e-6);
}

TEST_F(RangeOutputs, WithoutRangesTheTablesAreEmpty) {
  test::writeRecording(rawlog_, 10);
  const results::RunSummary s = run();
  EXPECT_EQ(table("ranges.csv").size(), 1u);
  EXPECT_EQ(table("anchors.csv").size(), 1u);
  EXPECT_EQ(s.ranges_accepted + s.ranges_collected + s.ranges_rejected, 0);
}

}  // namespace
}  // namespace vir::runs
