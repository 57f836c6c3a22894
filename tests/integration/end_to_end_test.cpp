/// What a user with a EuRoC recording gets: import, run, and results that are as good as measured
/// when this was written (about 0.006 m on MH01, 0.004 m on the rendered flight).
#include "end_to_end.h"

#include <gtest/gtest.h>

namespace vir {
namespace {

using test::quoted;
using test::RunResult;

/// A pose for every image from the first pose on, and no other.
void expectPoseForEveryImage(const std::vector<TimeNs>& images, const Trajectory& trajectory) {
  ASSERT_FALSE(trajectory.empty());
  // Poses are on the IMU's clock: what is found of the camera's time offset moves them.
  const TimeNs tick = fromSeconds(0.001);
  auto image = std::find_if(images.begin(), images.end(),
                            [&](TimeNs t) { return t > trajectory.front().t - tick; });
  ASSERT_EQ(images.end() - image, static_cast<std::ptrdiff_t>(trajectory.size()));
  long elsewhere = 0;
  for (const StampedPose& pose : trajectory) elsewhere += std::abs(pose.t - *image++) > tick;
  EXPECT_EQ(elsewhere, 0);
}

/// Largest distance of the last `seconds` from where they begin [m].
double wandering(const Trajectory& trajectory, double seconds) {
  const TimeNs from = trajectory.back().t - fromSeconds(seconds);
  const StampedPose* first = nullptr;
  double most = 0;
  for (const StampedPose& pose : trajectory) {
    if (pose.t < from) continue;
    if (first == nullptr) first = &pose;
    most = std::max(most, (pose.T_W_B.p - first->T_W_B.p).norm());
  }
  return most;
}

RunResult importAndRun(const std::string& source, const test::TempFolder& folder) {
  const std::string rawlog = (folder / "a.rawlog").string();
  const test::Outcome import = test::importEuroc(source, rawlog);
  EXPECT_EQ(import.code, 0) << import.text;
  return test::runVir(rawlog, (folder / "out").string());
}

void expectGood(const RunResult& r, const std::filesystem::path& recording, double ate_m) {
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  ASSERT_TRUE(r.summary.is_object());
  std::printf("measured: first pose %.2f s, ATE %.4f m, smoothed %.4f m, %.0f MB, %.1f ms/image\n",
              r.summary["init_time_s"].get<double>(), r.summary["ate_posyaw_m"].get<double>(),
              r.summary["ate_smoothed_posyaw_m"].get<double>(),
              r.summary["peak_rss_mb"].get<double>(), r.summary["cpu_ms_per_frame"].get<double>());
  EXPECT_LE(r.summary["init_time_s"], 2.0);
  EXPECT_LE(r.summary["ate_posyaw_m"], ate_m);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_EQ(r.summary["verdict"], "good") << r.summary["doubts"];
  EXPECT_TRUE(r.summary["warnings"].empty()) << r.summary["warnings"];
  EXPECT_LE(r.summary["peak_rss_mb"], 100);
  EXPECT_EQ(test::notFinite(r.folder), "");
  expectPoseForEveryImage(test::imageStamps(recording), r.trajectory);
}

TEST(EndToEnd, Mh01AndStandsStillWhereTheDroneDoes) {
  VIR_REQUIRE_DATA(recording, test::kMh01);
  const test::TempFolder folder;
  const RunResult r = importAndRun(recording.string(), folder);
  expectGood(r, recording, 0.0085);
  if (HasFatalFailure()) return;
  const double moved = wandering(r.trajectory, 13);
  std::printf("measured: moves by %.5f m in the last 13 s\n", moved);
  EXPECT_LE(moved, 0.003);
}

TEST(EndToEnd, RenderedFlight) {
  VIR_REQUIRE_DATA(recording, test::kRendered);
  const test::TempFolder folder;
  expectGood(importAndRun(recording.string(), folder), recording, 0.010);
}

TEST(EndToEnd, SameInputSameBytes) {
  VIR_REQUIRE_DATA(recording, test::kRendered);
  const test::TempFolder folder;
  const std::string rawlog = (folder / "a.rawlog").string();
  const test::Outcome import =
      test::importEuroc(recording.string(), rawlog, "--set euroc.max_duration_s=8");
  ASSERT_EQ(import.code, 0) << import.text;
  for (const std::string out : {"1", "2"}) {
    ASSERT_EQ(test::runVir(rawlog, (folder / out).string()).outcome.code, 0);
  }
  for (const std::string file : {"trajectory.tum", "trajectory_smoothed.tum", "landmarks.ply"}) {
    const std::string first = test::readText(folder.path() / "1" / file);
    EXPECT_GT(first.size(), 1000u) << file;
    EXPECT_TRUE(first == test::readText(folder.path() / "2" / file)) << file << " differs";
  }
}

/// The estimator is started anywhere in a recording, not only where it was tuned.
class Restart : public testing::TestWithParam<std::pair<std::string, double>> {};

TEST_P(Restart, FindsItsPoseWithinSixSeconds) {
  const auto& [name, offset] = GetParam();
  VIR_REQUIRE_DATA(recording, name);
  const test::TempFolder folder;
  const std::string rawlog = (folder / "a.rawlog").string();
  const test::Outcome import = test::importEuroc(
      recording.string(), rawlog, "--set euroc.max_duration_s=" + std::to_string(offset + 6));
  ASSERT_EQ(import.code, 0) << import.text;
  const RunResult r = test::runVir(rawlog, (folder / "out").string(),
                                   "--set Estimator.start_offset_s=" + std::to_string(offset));
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  std::printf("measured: %s +%.1f s: first pose %.2f s, ATE %.4f m, resets %d\n", name.c_str(),
              offset, r.summary["init_time_s"].get<double>(),
              r.summary["ate_posyaw_m"].get<double>(), r.summary["resets"].get<int>());
  EXPECT_LE(r.summary["init_time_s"], 2.5);
  EXPECT_LT(r.summary["ate_posyaw_m"], 0.015);
  EXPECT_EQ(r.summary["resets"], 0);
}

INSTANTIATE_TEST_SUITE_P(Offsets, Restart,
                         testing::Values(std::pair<std::string, double>{test::kMh01, 2.5},
                                         std::pair<std::string, double>{test::kMh01, 5},
                                         std::pair<std::string, double>{test::kMh01, 8},
                                         std::pair<std::string, double>{test::kRendered, 4},
                                         std::pair<std::string, double>{test::kRendered, 12.5},
                                         std::pair<std::string, double>{test::kRendered, 21}),
                         [](const auto& info) {
                           return info.param.first.substr(0, info.param.first.find('_')) + "_" +
                                  std::to_string(static_cast<int>(1000 * info.param.second)) + "ms";
                         });

}  // namespace
}  // namespace vir
