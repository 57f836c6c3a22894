/// A run that is found in a map leaps there; nothing has moved.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "silent_estimator.h"
#include "vir/evaluation/trajectory.h"
#include "vir/results/run_recorder.h"
#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

constexpr TimeNs kStart = 1'700'000'000'000'000'000;

StampedPose truthAt(int i) {
  const double a = 0.01 * i;
  return {kStart + i * 100'000'000LL, Pose(Quat(Eigen::AngleAxisd(a, Vec3::UnitZ())),
                                           Vec3(3 * std::cos(a), 3 * std::sin(a), 1))};
}

/// A run without errors, at 10 Hz, that is found after 20 s in a map that lies at T_M_W.
struct FoundRun {
  FoundRun() : folder(temp / "results"), recorder(folder, {}) {
    recorder.setFirstFrame(kStart);
    const Pose T_W_M = T_M_W.inverse();
    for (int i = 0; i < 400; ++i) {
      const StampedPose truth = truthAt(i);
      roles::EstimatorOutput out;
      StateEstimate e;
      e.state.t = truth.t;
      e.valid = true;
      e.health = Health::ok;
      e.state.T_W_B = i < 200 ? T_W_M * truth.T_W_B : truth.T_W_B;
      e.covariance.diagonal() << 1e-4, 4e-4, 1e-4, 1e-6, 1e-6, 1e-6;
      out.states.push_back(e);
      if (i == 200) out.frame_changes.push_back({truth.t, T_M_W});
      recorder.onOutput(out, SilentEstimator());
      recorder.addGroundTruth(truth.t, truth.T_W_B);
    }
    recorder.onEnd(SilentEstimator(), &summary);
  }

  const Pose T_M_W{Quat(Eigen::AngleAxisd(1.2, Vec3::UnitZ())), Vec3(40, -25, 3)};
  const test::TempFolder temp;
  const ResultsFolder folder;
  RunRecorder recorder;
  RunSummary summary;
};

TEST(FrameChange, IsNoErrorAndNoWay) {
  const FoundRun run;
  EXPECT_NEAR(run.summary.path_m, 399 * 0.03, 1e-3);
  ASSERT_TRUE(run.summary.ate_posyaw_m && run.summary.rpe_1s_m && run.summary.rpe_10m_m);
  EXPECT_LT(*run.summary.ate_posyaw_m, 1e-6);
  EXPECT_LT(*run.summary.ate_posyaw_deg, 1e-4);
  EXPECT_LT(*run.summary.rpe_1s_m, 1e-6);
  EXPECT_LT(*run.summary.rpe_10m_m, 1e-6);
  EXPECT_LT(*run.summary.nees_position, 1e-6);
  ASSERT_TRUE(run.summary.in_map_s);
  EXPECT_DOUBLE_EQ(*run.summary.in_map_s, 20);
  EXPECT_NE(toJson(run.summary).find("\"in_map_s\": 20.0"), std::string::npos);
}

/// Until it is found a run drifts as its covariances say, from where it started; the leap takes the
/// drift off, in the map's frame also at the start. No covariance spoke of that.
TEST(FrameChange, ErrorsAreThoseOfTheWorldTheyWereMadeIn) {
  const test::TempFolder temp;
  const ResultsFolder folder(temp / "results");
  RunRecorder recorder(folder, {});
  recorder.setFirstFrame(kStart);
  SilentEstimator estimator;
  const auto drift_m = [](int i) { return 0.005 * i; };
  for (int i = 0; i < 400; ++i) {
    const StampedPose truth = truthAt(i);
    const bool found = i >= 200;
    roles::EstimatorOutput out;
    StateEstimate e;
    e.state.t = truth.t;
    e.valid = true;
    e.health = Health::ok;
    e.state.T_W_B = truth.T_W_B;
    if (!found) e.state.T_W_B.p.x() += drift_m(i);
    const double variance = 1e-6 + (found ? 0 : drift_m(i) * drift_m(i));
    e.covariance.diagonal() << variance, variance, variance, 1e-6, 1e-6, 1e-6;
    out.states.push_back(e);
    estimator.keyframes_.push_back(truth);
    if (i == 200) {
      out.frame_changes.push_back({truth.t, Pose(Quat::Identity(), Vec3(-drift_m(i), 0, 0))});
    }
    recorder.onOutput(out, estimator);
    recorder.addGroundTruth(truth.t, truth.T_W_B);
  }
  RunSummary summary;
  recorder.onEnd(estimator, &summary);
  ASSERT_TRUE(summary.nees_position);
  EXPECT_NEAR(*summary.nees_position, 0.5 / 3, 0.01);  // half the run, one axis of three
}

/// The file itself stays as the states were given; whoever reads it has one frame.
TEST(FrameChange, IsToldInTheTrajectory) {
  const FoundRun run;
  std::ifstream in(run.folder.file("trajectory.tum"));
  std::string first;
  std::getline(in, first);
  EXPECT_EQ(first, evaluation::tumLine({kStart, run.T_M_W.inverse() * truthAt(0).T_W_B}));
  in.seekg(0);
  evaluation::ReadReport report;
  const Trajectory read = evaluation::readTrajectory(in, &report);
  EXPECT_EQ(report.skipped(), 0);
  ASSERT_EQ(read.size(), 400u);
  for (const int i : {0, 199, 200, 399}) {
    const Pose& pose = read[static_cast<std::size_t>(i)].T_W_B;
    EXPECT_LT((pose.p - truthAt(i).T_W_B.p).norm(), 1e-6) << i;
    EXPECT_LT(pose.q.angularDistance(truthAt(i).T_W_B.q), 1e-7) << i;
  }
}

}  // namespace
}  // namespace vir::results
