/// The memory of a run that is being recorded does not grow with its length.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "silent_estimator.h"
#include "vir/evaluation/trajectory.h"
#include "vir/results/run_recorder.h"
#include "vir_test_heap.h"
#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

constexpr TimeNs kStart = 1'700'000'000'000'000'000;

/// Image `i` of a flight at 10 Hz, with a range, a calibration, and a keyframe that settles.
roles::EstimatorOutput outputAt(int i) {
  roles::EstimatorOutput out;
  StateEstimate e;
  e.state.t = kStart + i * 100'000'000LL;
  e.valid = true;
  e.health = i % 300 < 5 ? Health::doubtful : Health::ok;
  e.state.T_W_B.p = Vec3(std::sin(0.01 * i), std::cos(0.01 * i), 1);
  e.covariance.setIdentity();
  out.states.push_back(e);
  RangeRecord range;
  range.t = e.state.t;
  range.anchor = 7;
  range.measured_m = 5;
  out.ranges.push_back(range);
  out.calibrations.push_back({e.state.t, {}, {}});
  out.settled.push_back({e.state.t - 50'000'000'000LL, e.state.T_W_B});
  return out;
}

TEST(LongRun, MemoryStaysAsItIs) {
  if (!test::heapIsCounted()) GTEST_SKIP() << "the heap is the sanitizer's";
  const test::TempFolder temp;
  const ResultsFolder folder(temp / "results");
  const SilentEstimator estimator;
  RunRecorder recorder(folder, {});
  const test::HeapPeak heap;
  long after_a_while = 0;
  for (int i = 0; i < 36000; ++i) {
    recorder.onOutput(outputAt(i), estimator);
    recorder.addGroundTruth(kStart + i * 100'000'000LL, Pose());
    if (i == 9000) after_a_while = heap.now();
  }
  EXPECT_LT(heap.now() - after_a_while, 200'000) << "bytes in 45 minutes";
}

/// As they settled, as they were last revised, as they are in the end: each keyframe once.
TEST(LongRun, AllKeyframesAreInTheSmoothedTrajectory) {
  const test::TempFolder temp;
  const ResultsFolder folder(temp / "results");
  SilentEstimator estimator;
  RunRecorder recorder(folder, {});
  const auto at = [](int s, double x) {
    return StampedPose{kStart + s * 1'000'000'000LL, Pose(Quat::Identity(), Vec3(x, 0, 0))};
  };
  roles::EstimatorOutput out;
  out.revisions.push_back({kStart, {at(1, 0.1), at(2, 0.2), at(3, 0.3)}});
  out.settled = {at(1, 1), at(2, 2)};
  recorder.onOutput(out, estimator);
  out = {};
  out.revisions.push_back({kStart, {at(2, 22)}});  // after all
  recorder.onOutput(out, estimator);
  estimator.keyframes_ = {at(4, 4)};
  RunSummary summary;
  recorder.onEnd(estimator, &summary);
  std::ifstream file(folder.file("trajectory_smoothed.tum"));
  evaluation::ReadReport report;
  const Trajectory smoothed = evaluation::readTum(file, &report);
  ASSERT_EQ(smoothed.size(), 4u);
  EXPECT_EQ(smoothed[0].T_W_B.p.x(), 1);
  EXPECT_EQ(smoothed[1].T_W_B.p.x(), 22);
  EXPECT_EQ(smoothed[2].T_W_B.p.x(), 0.3);
  EXPECT_EQ(smoothed[3].T_W_B.p.x(), 4);
}

}  // namespace
}  // namespace vir::results
