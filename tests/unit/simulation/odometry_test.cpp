/// Simulated odometry drifts as asked for.
#include <gtest/gtest.h>

#include "made_motions.h"
#include "vir/simulation/simulate_odometry.h"

namespace {

using namespace vir;

vir::simulation::OdometrySimulationOptions perfect() {
  vir::simulation::OdometrySimulationOptions o;
  o.scale_error = o.scale_wander = o.yaw_walk = o.position_walk = 0;
  o.position_noise_m = o.attitude_noise_rad = 0;
  return o;
}

TEST(SimulatedOdometry, WithoutErrorsIsTheMotionFromItsStart) {
  const auto motion = vir_test::briskFlight();
  const Trajectory odometry = vir::simulation::simulateOdometry(*motion, perfect());
  const Pose first = motion->poseAt(motion->begin());
  EXPECT_NEAR(yawOf(odometry.front().T_W_B.R()), 0, 1e-12);
  for (const StampedPose& s : odometry) {
    const Pose truth = first.inverse() * motion->poseAt(s.t);
    const Pose got = odometry.front().T_W_B.inverse() * s.T_W_B;
    EXPECT_LT((got.p - truth.p).norm(), 1e-9);
    EXPECT_LT(logQuat(got.q.conjugate() * truth.q).norm(), 1e-9);
  }
}

TEST(SimulatedOdometry, ScaleAndYawDrift) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::OdometrySimulationOptions o = perfect();
  o.scale_error = 0.15;
  const Trajectory longer = vir::simulation::simulateOdometry(*motion, o);
  const Vec3 truth = motion->poseAt(longer.back().t).p - motion->poseAt(motion->begin()).p;
  EXPECT_NEAR(longer.back().T_W_B.p.norm(), 1.15 * truth.norm(), 1e-9);

  o = perfect();
  o.yaw_drift_radps = 0.01;
  const Trajectory turned = vir::simulation::simulateOdometry(*motion, o);
  const Mat3 R = turned.back().T_W_B.R() * motion->poseAt(turned.back().t).R().transpose();
  const double drift = std::remainder(
      std::atan2(R(1, 0), R(0, 0)) + yawOf(motion->poseAt(motion->begin()).R()), 2 * M_PI);
  EXPECT_NEAR(drift, 0.01 * toSeconds(turned.back().t - turned.front().t), 1e-6);
}

TEST(SimulatedOdometry, ScaleWandersAboutItsMean) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::OdometrySimulationOptions o = perfect();
  o.scale_wander = 0.1;
  double sum = 0, square = 0;
  constexpr int n = 40;
  for (int seed = 1; seed <= n; ++seed) {
    o.seed = seed;
    const Trajectory t = vir::simulation::simulateOdometry(*motion, o);
    // Over one second in full flight, far less than the time constant.
    const std::size_t k = t.size() / 2;
    const double got = (t[k + 20].T_W_B.p - t[k].T_W_B.p).norm();
    const double truth = (motion->poseAt(t[k + 20].t).p - motion->poseAt(t[k].t).p).norm();
    sum += got / truth - 1;
    square += std::pow(got / truth - 1, 2);
  }
  EXPECT_NEAR(sum / n, 0, 0.06);
  EXPECT_NEAR(std::sqrt(square / n), 0.1, 0.04);
}

TEST(SimulatedOdometry, SameSeedSamePoses) {
  const auto motion = vir_test::standing(5);
  const Trajectory a = vir::simulation::simulateOdometry(*motion, {}),
                   b = vir::simulation::simulateOdometry(*motion, {});
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].T_W_B.p, b[k].T_W_B.p);
}

}  // namespace
