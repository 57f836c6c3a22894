#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "vir/imu/preintegration.h"

namespace vir::imu {
namespace {

constexpr double kStep = 0.005;
constexpr int kSteps = 100;  // half a second

Vec3 gyroAt(int k) { return {0.5 * std::sin(0.02 * k), 0.4, -0.3 * std::cos(0.03 * k)}; }
Vec3 accAt(int k) { return {2 * std::sin(0.03 * k), 1.0, 9.81}; }

class Noise {
 public:
  explicit Noise(unsigned seed) : random_(seed) {}
  Vec3 operator()(double sigma) {
    const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
    return sigma * Vec3(x, y, z);
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

/// Integrates with white noise and a walking bias on every interval; the interval's two readings
/// carry the same error, as the model has it (noise per interval, variance s^2 / dt).
Preintegration noisyRun(const ImuNoise& n, unsigned seed, Vec15* final_bias) {
  Noise noise(seed);
  Vec3 bg = Vec3::Zero(), ba = Vec3::Zero();
  Preintegration p(n, Vec3::Zero(), Vec3::Zero());
  for (int k = 0; k < kSteps; ++k) {
    const Vec3 ng = bg + noise(n.noise_scale * n.gyro_noise_density / std::sqrt(kStep));
    const Vec3 na = ba + noise(n.noise_scale * n.acc_noise_density / std::sqrt(kStep));
    p.integrate({fromSeconds(k * kStep), gyroAt(k) + ng, accAt(k) + na},
                {fromSeconds((k + 1) * kStep), gyroAt(k + 1) + ng, accAt(k + 1) + na});
    bg += noise(n.gyro_random_walk * std::sqrt(kStep));
    ba += noise(n.acc_random_walk * std::sqrt(kStep));
  }
  final_bias->segment<3>(kBg) = bg;
  final_bias->segment<3>(kBa) = ba;
  return p;
}

Preintegration cleanRun(const ImuNoise& n) {
  Preintegration p(n, Vec3::Zero(), Vec3::Zero());
  for (int k = 0; k < kSteps; ++k) {
    p.integrate({fromSeconds(k * kStep), gyroAt(k), accAt(k)},
                {fromSeconds((k + 1) * kStep), gyroAt(k + 1), accAt(k + 1)});
  }
  return p;
}

Mat15 sampleCovariance(const ImuNoise& n, int runs) {
  const Preintegration truth = cleanRun(n);
  Mat15 sum = Mat15::Zero();
  for (int r = 0; r < runs; ++r) {
    Vec15 e;
    const Preintegration p = noisyRun(n, 1000 + r, &e);
    // What the readings say minus what truly happened; biases: truth walked away from zero.
    e.segment<3>(kP) = p.dp() - truth.dp();
    e.segment<3>(kTheta) = logQuat(truth.dq().conjugate() * p.dq());
    e.segment<3>(kV) = p.dv() - truth.dv();
    e.segment<6>(kBg) = -e.segment<6>(kBg);
    sum += e * e.transpose();
  }
  return sum / runs;
}

/// Largest relative deviation of a variance along any direction: |L^-1 S L^-T - I| eigenvalues.
void expectConsistent(const ImuNoise& n, const char* what) {
  const int runs = 800;
  const Mat15 model = cleanRun(n).covariance();
  const Mat15 sample = sampleCovariance(n, runs);
  for (int i = 0; i < 15; ++i) {
    EXPECT_NEAR(std::sqrt(sample(i, i) / model(i, i)), 1, 0.1) << what << ", state " << i;
  }
  // Mean of e^T P^-1 e is the dimension: 15, with a standard deviation of sqrt(2*15/runs) = 0.19.
  const double nees = model.llt().solve(sample).trace();
  EXPECT_NEAR(nees, 15, 1.0) << what;
}

TEST(ImuCovariance, WhiteNoiseAgainstMonteCarlo) {
  ImuNoise n;
  n.noise_scale = 1;
  n.gyro_noise_density = 2e-3;
  n.acc_noise_density = 2e-2;
  n.gyro_random_walk = 1e-4;
  n.acc_random_walk = 1e-3;
  expectConsistent(n, "white noise");
}

TEST(ImuCovariance, BiasWalkAgainstMonteCarlo) {
  ImuNoise n;
  n.noise_scale = 1;
  n.gyro_noise_density = 1e-4;
  n.acc_noise_density = 1e-3;
  n.gyro_random_walk = 1e-2;
  n.acc_random_walk = 1e-1;
  expectConsistent(n, "bias walk");
}

TEST(ImuCovariance, ScaleMultipliesWhiteNoiseOnly) {
  ImuNoise n;
  n.gyro_random_walk = n.acc_random_walk = 1e-3;
  n.noise_scale = 1;
  const Mat15 one = cleanRun(n).covariance();
  n.noise_scale = 4;
  const Mat15 four = cleanRun(n).covariance();
  EXPECT_EQ(one.bottomRightCorner(6, 6), four.bottomRightCorner(6, 6));
  n.gyro_random_walk = n.acc_random_walk = 1e-9;
  n.noise_scale = 1;
  const Mat15 a = cleanRun(n).covariance();
  n.noise_scale = 4;
  const Mat15 b = cleanRun(n).covariance();
  EXPECT_NEAR(b(kTheta, kTheta) / a(kTheta, kTheta), 16, 1e-3);
  EXPECT_NEAR(b(kV, kV) / a(kV, kV), 16, 1e-3);
}

TEST(ImuCovariance, AFactorInflatesTheIntervalItIsGivenFor) {
  ImuNoise n;
  n.noise_scale = 1;
  const ImuSample a{0, Vec3::Zero(), Vec3(0, 0, 9.81)}, b{10000000, Vec3::Zero(), Vec3(0, 0, 9.81)};
  Preintegration one(n, Vec3::Zero(), Vec3::Zero()), ten(n, Vec3::Zero(), Vec3::Zero());
  one.integrate(a, b);
  ten.integrate(a, b, 10);
  EXPECT_NEAR(ten.covariance()(kTheta, kTheta) / one.covariance()(kTheta, kTheta), 100, 1e-6);
  // s^2 dt of a white noise s over an interval dt: (1.7e-4)^2 * 0.01 = 2.89e-10
  EXPECT_NEAR(one.covariance()(kTheta, kTheta), 2.89e-10, 1e-14);
}

}  // namespace
}  // namespace vir::imu
