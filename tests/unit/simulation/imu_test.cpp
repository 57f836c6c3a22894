/// The simulated IMU has the errors that were asked for, and no others.
#include <gtest/gtest.h>

#include <cmath>

#include "made_motions.h"
#include "vir/simulation/simulate_imu.h"

namespace {

using namespace vir;

vir::simulation::ImuSimulationOptions perfect() {
  vir::simulation::ImuSimulationOptions o;
  o.gyro_noise_density = o.acc_noise_density = o.gyro_random_walk = o.acc_random_walk = 0;
  o.initial_bias_gyro = o.initial_bias_acc = 0;
  return o;
}

TEST(SimulatedImu, WithoutErrorsReadsTheMotion) {
  const auto motion = vir_test::briskFlight();
  const vir::simulation::SimulatedImu imu = vir::simulation::simulateImu(*motion, perfect());
  EXPECT_NEAR(static_cast<double>(imu.samples.size()), motion->duration() * 200, 2);
  for (std::size_t k = 0; k < imu.samples.size(); k += 37) {
    const ImuSample& s = imu.samples[k];
    const vir::simulation::MotionState m = motion->at(s.t);
    EXPECT_LT((s.gyro - m.rate_B).norm(), 1e-12);
    const Vec3 a_W = m.T_W_B.q * s.acc + Vec3(0, 0, -9.81);
    EXPECT_LT((a_W - m.a_W).norm(), 1e-12);
  }
}

TEST(SimulatedImu, AtRestReadsUpwards) {
  const auto motion = vir_test::standing(2);
  for (const ImuSample& s : vir::simulation::simulateImu(*motion, perfect()).samples) {
    EXPECT_LT((motion->poseAt(s.t).q * s.acc - Vec3(0, 0, 9.81)).norm(), 1e-9);
  }
}

/// Standard deviation of averages over `n` readings, differences of neighbours (Allan deviation).
double allan(const std::vector<double>& x, std::size_t n) {
  std::vector<double> means;
  for (std::size_t k = 0; k + n <= x.size(); k += n) {
    double sum = 0;
    for (std::size_t j = 0; j < n; ++j) sum += x[k + j];
    means.push_back(sum / static_cast<double>(n));
  }
  double square = 0;
  for (std::size_t k = 1; k < means.size(); ++k) square += std::pow(means[k] - means[k - 1], 2);
  return std::sqrt(square / (2 * static_cast<double>(means.size() - 1)));
}

TEST(SimulatedImu, AllanDeviationFitsTheDensities) {
  const auto motion = vir_test::standing(1000);
  vir::simulation::ImuSimulationOptions noise = perfect(), walk = perfect();
  noise.gyro_noise_density = 2e-4;
  noise.acc_noise_density = 1.5e-3;
  walk.gyro_random_walk = 3e-5;
  walk.acc_random_walk = 3e-3;
  const vir::simulation::SimulatedImu white = vir::simulation::simulateImu(*motion, noise),
                                      walking = vir::simulation::simulateImu(*motion, walk);
  const auto column = [](const vir::simulation::SimulatedImu& imu, bool gyro, int axis) {
    std::vector<double> out;
    for (const ImuSample& s : imu.samples) out.push_back(gyro ? s.gyro[axis] : s.acc[axis]);
    return out;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool gyro : {true, false}) {
      // White noise: density / sqrt(tau). Random walk: density * sqrt(tau / 3).
      const double n = gyro ? 2e-4 : 1.5e-3, k = gyro ? 3e-5 : 3e-3;
      const std::vector<double> x = column(white, gyro, axis), y = column(walking, gyro, axis);
      EXPECT_NEAR(allan(x, 20) / (n / std::sqrt(0.1)), 1, 0.05) << axis << gyro;
      EXPECT_NEAR(allan(x, 200) / (n / std::sqrt(1.0)), 1, 0.12) << axis << gyro;
      EXPECT_NEAR(allan(y, 200) / (k * std::sqrt(1.0 / 3)), 1, 0.12) << axis << gyro;
      EXPECT_NEAR(allan(y, 1000) / (k * std::sqrt(5.0 / 3)), 1, 0.25) << axis << gyro;
    }
  }
}

TEST(SimulatedImu, FirstBiasesHaveTheirSpread) {
  const auto motion = vir_test::standing(1);
  vir::simulation::ImuSimulationOptions o;
  double square = 0;
  for (int seed = 1; seed <= 200; ++seed) {
    o.seed = seed;
    square += vir::simulation::simulateImu(*motion, o).bias_gyro.front().squaredNorm() / 3;
  }
  EXPECT_NEAR(std::sqrt(square / 200), o.initial_bias_gyro, 0.1 * o.initial_bias_gyro);
}

TEST(SimulatedImu, SameSeedSameReadingsAndOneErrorLeavesTheOthers) {
  const auto motion = vir_test::standing(3);
  vir::simulation::ImuSimulationOptions o;
  const vir::simulation::SimulatedImu a = vir::simulation::simulateImu(*motion, o),
                                      b = vir::simulation::simulateImu(*motion, o);
  vir::simulation::ImuSimulationOptions walking = o;
  walking.gyro_random_walk *= 10;
  walking.dropped_share = 0;
  const vir::simulation::SimulatedImu c = vir::simulation::simulateImu(*motion, walking);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t k = 0; k < a.samples.size(); ++k) {
    EXPECT_EQ(a.samples[k].gyro, b.samples[k].gyro);
    EXPECT_EQ(a.samples[k].acc, b.samples[k].acc);
    EXPECT_EQ(a.samples[k].acc, c.samples[k].acc);
  }
  o.seed = 2;
  EXPECT_NE(vir::simulation::simulateImu(*motion, o).samples[0].gyro, a.samples[0].gyro);
}

TEST(SimulatedImu, ReadingsAreLostAndClippedAsAskedFor) {
  const auto motion = vir_test::standing(50);
  vir::simulation::ImuSimulationOptions o = perfect();
  o.dropped_share = 0.2;
  o.saturation_acc_mps2 = 5;
  const vir::simulation::SimulatedImu imu = vir::simulation::simulateImu(*motion, o);
  EXPECT_NEAR(static_cast<double>(imu.samples.size()), 0.8 * 50 * 200, 200);
  for (const ImuSample& s : imu.samples) EXPECT_LE(s.acc.cwiseAbs().maxCoeff(), 5);
}

}  // namespace
