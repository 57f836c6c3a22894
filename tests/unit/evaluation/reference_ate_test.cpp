/// The ATE once more, written another way: its own association, and the optimum found by
/// Gauss-Newton on yaw and translation from many starts instead of in closed form.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <fstream>
#include <map>

#include "made_trajectories.h"
#include "vir/evaluation/evaluate.h"
#include "vir_test_paths.h"

namespace vir::evaluation {
namespace {

struct Sample {
  Eigen::Vector3d ref, est;
};

/// Own association: an ordered map and seconds relative to the first stamp.
std::vector<Sample> samplesOf(const Trajectory& reference, const Trajectory& estimate) {
  const TimeNs origin = reference.front().t;
  std::map<double, Eigen::Vector3d> ref;
  for (const StampedPose& r : reference) ref[(r.t - origin) * 1e-9] = r.T_W_B.p;
  std::vector<Sample> samples;
  for (const StampedPose& e : estimate) {
    const double t = (e.t - origin) * 1e-9;
    const auto after = ref.lower_bound(t);
    if (after == ref.end() || (after == ref.begin() && after->first > t)) continue;
    if (after->first == t) {
      samples.push_back({after->second, e.T_W_B.p});
      continue;
    }
    const auto before = std::prev(after);
    const double dt = after->first - before->first;
    if (dt > 0.1) continue;
    const double w = (after->first - t) / dt;
    samples.push_back({w * before->second + (1 - w) * after->second, e.T_W_B.p});
  }
  return samples;
}

double cost(const std::vector<Sample>& samples, const Eigen::Vector4d& x) {
  double sum = 0;
  for (const Sample& s : samples) {
    const Eigen::Vector3d p = Eigen::AngleAxisd(x[0], Eigen::Vector3d::UnitZ()) * s.est;
    sum += (p + x.tail<3>() - s.ref).squaredNorm();
  }
  return sum;
}

double bestRmse(const std::vector<Sample>& samples) {
  double best = 1e300;
  for (int start = 0; start < 8; ++start) {
    Eigen::Vector4d x(start * 0.785398, 0, 0, 0);
    for (int iteration = 0; iteration < 100; ++iteration) {
      Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
      Eigen::Vector4d g = Eigen::Vector4d::Zero();
      for (const Sample& s : samples) {
        const Eigen::Vector3d p = Eigen::AngleAxisd(x[0], Eigen::Vector3d::UnitZ()) * s.est;
        Eigen::Matrix<double, 3, 4> J;
        J << Eigen::Vector3d::UnitZ().cross(p), Eigen::Matrix3d::Identity();
        H += J.transpose() * J;
        g += J.transpose() * (p + x.tail<3>() - s.ref);
      }
      const Eigen::Vector4d step = H.ldlt().solve(-g);
      x += step;
      if (step.norm() < 1e-14) break;
    }
    best = std::min(best, cost(samples, x));
  }
  return std::sqrt(best / static_cast<double>(samples.size()));
}

void expectSame(const Trajectory& reference, const Trajectory& estimate) {
  const double own = evaluate(reference, estimate, {}).ate_position_m.rmse;
  const std::vector<Sample> samples = samplesOf(reference, estimate);
  const double other = bestRmse(samples);
  ASSERT_GT(other, 1e-3);
  EXPECT_NEAR(own, other, 1e-6 * other);
}

/// The estimate an odometry could give: 20 Hz, off-phase, noise and a random walk, its own world.
Trajectory drifting(const Trajectory& truth, unsigned seed) {
  const long step = 10;
  Trajectory sparse;
  const Trajectory rough = test::noisy(truth, 0.01, 0.01, seed);
  Trajectory walk = test::noisy(truth, 0.02, 0, seed + 1);
  Vec3 drift = Vec3::Zero();
  for (std::size_t i = 0; i + 1 < rough.size(); i += step) {
    drift += walk[i].T_W_B.p - truth[i].T_W_B.p;
    StampedPose pose = rough[i];
    const double s = 0.37;  // between two poses of the truth
    const TimeNs dt = truth[i + 1].t - truth[i].t;
    pose.t += static_cast<TimeNs>(s * static_cast<double>(dt));
    pose.T_W_B.p += s * (truth[i + 1].T_W_B.p - truth[i].T_W_B.p) + drift;
    sparse.push_back(pose);
  }
  return test::seenFrom(sparse, Pose(Quat(rotZ(2.2)), Vec3(-4, 9, 1)));
}

TEST(ReferenceAte, AgreesOnMadeMotion) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Trajectory truth = test::winding(30, 200);
    expectSame(truth, drifting(truth, seed));
  }
}

/// Every n-th pose.
Trajectory every(const Trajectory& trajectory, std::size_t n) {
  Trajectory out;
  for (std::size_t i = 3; i < trajectory.size(); i += n) out.push_back(trajectory[i]);
  return out;
}

/// 1 Hz against an estimate whose stamps are others: there the estimate is interpolated.
TEST(ReferenceAte, AgreesOnASparseReference) {
  const Trajectory truth = test::winding(60, 200);
  const Trajectory estimate = drifting(truth, 3), reference = every(truth, 200);
  std::vector<Sample> samples = samplesOf(estimate, reference);
  for (Sample& s : samples) std::swap(s.ref, s.est);
  ASSERT_GT(samples.size(), 50u);
  const EvaluationResult result = evaluate(reference, estimate, {});
  EXPECT_TRUE(result.association.estimate_interpolated);
  EXPECT_EQ(result.association.pairs.size(), samples.size());
  EXPECT_NEAR(result.ate_position_m.rmse, bestRmse(samples), 1e-6);
}

TEST(ReferenceAte, AgreesOnPositionsFarFromTheOrigin) {
  const Trajectory truth = test::winding(60, 20);
  const Trajectory estimate = drifting(truth, 4);
  Trajectory reference = truth;
  for (StampedPose& pose : reference) {
    pose.T_W_B = Pose(Quat::Identity(), pose.T_W_B.p + Vec3(744073.32, 2553112.02, 0.19));
  }
  const EvaluationResult result = evaluate(reference, estimate, {});
  EXPECT_FALSE(result.attitudes);
  EXPECT_NEAR(result.ate_position_m.rmse, bestRmse(samplesOf(truth, estimate)), 1e-6);
  EXPECT_EQ(result.ate_orientation_deg.count, 0);
  EXPECT_EQ(result.rpe_time.translation_m.count, 0);
}

TEST(ReferenceAte, PerfectRestHasNoError) {
  Trajectory truth;
  for (int i = 0; i < 200; ++i) {
    truth.push_back({1400000000000000000 + i * 50000000LL,
                     Pose(expQuat(Vec3(0.01, 0.02, 0.3)), Vec3(1, 2, 3))});
  }
  // A millimetre of noise, and a world turned by 100 degrees.
  const Trajectory estimate =
      test::seenFrom(test::noisy(truth, 0.001, 0.001, 5), Pose(Quat(rotZ(1.75)), Vec3(4, 5, 6)));
  const EvaluationResult result = evaluate(truth, estimate, {});
  EXPECT_LT(result.ate_position_m.rmse, 0.003);
  EXPECT_LT(result.ate_orientation_deg.rmse, 0.2);
}

TEST(ReferenceAte, SaysTheScale) {
  const Trajectory truth = test::winding(60, 20);
  EXPECT_NEAR(evaluate(truth, test::seenFrom(truth, Pose(), 1.25), {}).best_scale, 0.8, 1e-9);
}

TEST(ReferenceAte, AgreesOnRecordedMotion) {
  const char* env = std::getenv("VIR_TEST_DATA");
  const std::string folder =
      std::string(env ? env : test::sourceDir() + "/../shared/data") + "/trajectories/";
  int found = 0;
  for (const char* file : {"MH_01_easy.tum", "V1_02_medium.tum", "V2_01_easy.tum"}) {
    std::ifstream in(folder + file);
    if (!in) continue;
    ++found;
    ReadReport report;
    const Trajectory truth = readTrajectory(in, &report);
    EXPECT_EQ(report.skipped(), 0) << file;
    ASSERT_GT(truth.size(), 1000u) << file;
    expectSame(truth, drifting(truth, 7));
  }
  if (found == 0) GTEST_SKIP() << "no trajectories in " << folder << " (set VIR_TEST_DATA)";
}

}  // namespace
}  // namespace vir::evaluation
