#include "vir/factors/imu_factor.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "vir_test_jacobian.h"
#include "vir_test_poses.h"

namespace vir::factors {
namespace {

using vir_test::Blocks;
using vir_test::poseBlock;

imu::Preintegration turningLink(const Vec3& bg, const Vec3& ba) {
  imu::Preintegration p(imu::ImuNoise(), bg, ba);
  for (int k = 0; k < 40; ++k) {
    const auto at = [](int i) {
      return ImuSample{i * 5000000LL, Vec3(0.8 * std::sin(0.05 * i), 0.5, -0.7),
                       Vec3(1 + 0.02 * i, -2, 9.81)};
    };
    p.integrate(at(k), at(k + 1));
  }
  return p;
}

/// Where the link leads to from T_i, v_i, a little beside it.
Blocks blocksFrom(const Pose& T_i, const imu::Preintegration& link, double error) {
  const Vec3 v(0.5, -1, 0.3), bg(0.01, -0.02, 0.03), ba(0.1, 0.05, -0.1), g(0, 0, -9.81);
  const double dt = link.dt();
  const Vec3 e = error * Vec3(1, -2, 1.5);
  const Pose T_j((T_i.q * link.correctedDq(bg) * expQuat(e)).normalized(),
                 T_i.p + v * dt + 0.5 * g * dt * dt + T_i.q * link.correctedDp(bg, ba) + e);
  const Vec3 v_j = v + g * dt + T_i.q * link.correctedDv(bg, ba) - e;
  const auto sb = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::vector<double>{a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]};
  };
  return {poseBlock(T_i), sb(v, bg, ba), poseBlock(T_j), sb(v_j, bg + 0.1 * e, ba + e)};
}

/// S^-1 r: the residual without its weight.
imu::Vec15 unweighted(const ImuFactor& f, const imu::Preintegration& link, const Blocks& x) {
  return link.sqrtInformation().inverse() * vir_test::residualOf(f, x);
}

TEST(ImuFactor, JacobiansEverywhere) {
  const imu::Preintegration link = turningLink(Vec3(0.005, 0, 0.01), Vec3(0, 0.1, 0));
  const ImuFactor f(link, 9.81);
  vir_test::JacobianTolerance tolerance;
  tolerance.relative = 1e-7;
  tolerance.absolute = 1e-2;  // whitened by 1e-5 and less: entries reach 1e6
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    vir_test::expectJacobians(f, blocksFrom(p.T, link, 0.0), p.name + ", on the spot", tolerance);
    vir_test::expectJacobians(f, blocksFrom(p.T, link, 0.1), p.name + ", off", tolerance);
    vir_test::expectJacobians(f, blocksFrom(p.T, link, 0.8), p.name + ", far off", tolerance);
  }
}

imu::ImuIntrinsics someIntrinsics() {
  imu::ImuIntrinsics k;
  k << 0.01, -0.02, 0.005, 0.008, -0.01, 0.004, -0.01, 0.006, 0.012;
  return k;
}

TEST(ImuCalibrationFactor, JacobiansEverywhere) {
  const imu::Preintegration link = turningLink(Vec3(0.005, 0, 0.01), Vec3(0, 0.1, 0));
  const ImuCalibrationFactor f(link, 9.81);
  const imu::ImuIntrinsics k = someIntrinsics();
  vir_test::JacobianTolerance tolerance;
  tolerance.relative = 1e-7;
  tolerance.absolute = 1e-2;  // whitened by 1e-5 and less: entries reach 1e6
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    Blocks x = blocksFrom(p.T, link, 0.1);
    x.push_back(std::vector<double>(k.data(), k.data() + 9));
    vir_test::expectJacobians(f, x, p.name, tolerance);
  }
}

TEST(ImuCalibrationFactor, IsTheOtherFactorWithTheseIntrinsics) {
  const imu::Preintegration link = turningLink(Vec3::Zero(), Vec3::Zero());
  const imu::ImuIntrinsics k = someIntrinsics();
  const ImuCalibrationFactor estimated(link, 9.81);
  const ImuFactor known(link, 9.81, k);
  Blocks x = blocksFrom(vir_test::poses().back().T, link, 0.1);
  const Eigen::VectorXd r = vir_test::residualOf(known, x);
  x.push_back(std::vector<double>(k.data(), k.data() + 9));
  EXPECT_EQ(vir_test::residualOf(estimated, x), r);
  EXPECT_GT((r - vir_test::residualOf(ImuFactor(link, 9.81),
                                      blocksFrom(vir_test::poses().back().T, link, 0.1)))
                .norm(),
            1.0);
}

TEST(ImuFactor, ResidualByHand) {
  // At rest for 0.2 s: dp = 9.81 * 0.2^2 / 2 = 0.1962 m, dv = 1.962 m/s upwards.
  imu::Preintegration link(imu::ImuNoise(), Vec3::Zero(), Vec3::Zero());
  const Vec3 up(0, 0, 9.81);
  for (int k = 0; k < 40; ++k) {
    link.integrate({k * 5000000LL, Vec3::Zero(), up}, {(k + 1) * 5000000LL, Vec3::Zero(), up});
  }
  const ImuFactor f(link, 9.81);
  // i at the origin with v = (1, 0, 0); j at (0.3, 0, 0) turned by 0.1 about z, v = (1, 0, 0.5),
  // biases (0.001, 0, 0) and (0, 0.02, 0) further on.
  const Blocks x = {poseBlock(Pose()),
                    {1, 0, 0, 0, 0, 0, 0, 0, 0},
                    poseBlock(Pose(expQuat(Vec3(0, 0, 0.1)), Vec3(0.3, 0, 0))),
                    {1, 0, 0.5, 0.001, 0, 0, 0, 0.02, 0}};
  const imu::Vec15 r = unweighted(f, link, x);
  // r_p = p_j - p_i - v dt - g dt^2/2 - dp = 0.3 - 0.2 along x; z: 0.1962 - 0.1962 = 0
  EXPECT_LT((r.segment<3>(imu::kP) - Vec3(0.1, 0, 0)).norm(), 1e-9);
  EXPECT_LT((r.segment<3>(imu::kTheta) - Vec3(0, 0, 0.1)).norm(), 1e-9);
  // r_v = v_j - v_i - g dt - dv = (0, 0, 0.5 + 1.962 - 1.962)
  EXPECT_LT((r.segment<3>(imu::kV) - Vec3(0, 0, 0.5)).norm(), 1e-9);
  EXPECT_LT((r.segment<3>(imu::kBg) - Vec3(0.001, 0, 0)).norm(), 1e-9);
  EXPECT_LT((r.segment<3>(imu::kBa) - Vec3(0, 0.02, 0)).norm(), 1e-9);
}

TEST(ImuFactor, ResidualIsZeroWhereTheReadingsLead) {
  const imu::Preintegration link = turningLink(Vec3(0.01, -0.02, 0.03), Vec3(0.1, 0.05, -0.1));
  const ImuFactor f(link, 9.81);
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    EXPECT_LT(vir_test::residualOf(f, blocksFrom(p.T, link, 0)).norm(), 1e-6) << p.name;
  }
}

TEST(ImuFactor, WhitensWithTheCovariance) {
  // r^T P^-1 r must be the squared norm of what the factor returns.
  const imu::Preintegration link = turningLink(Vec3::Zero(), Vec3::Zero());
  const ImuFactor f(link, 9.81);
  const Blocks x = blocksFrom(Pose(), link, 1e-3);
  const Eigen::VectorXd white = vir_test::residualOf(f, x);
  const imu::Vec15 r = unweighted(f, link, x);
  EXPECT_NEAR(r.dot(link.covariance().inverse() * r) / white.squaredNorm(), 1, 1e-6);
}

TEST(ImuFactor, JacobiansStandAtTheFirstEstimateResidualsDoNot) {
  const imu::Preintegration link = turningLink(Vec3::Zero(), Vec3::Zero());
  const Blocks now = blocksFrom(vir_test::poses().back().T, link, 0.3);
  const Blocks first = blocksFrom(vir_test::poses()[1].T, link, 0.1);
  const ImuFactor plain(link, 9.81);
  for (int mask = 0; mask < 16; ++mask) {
    ImuFactor f(link, 9.81);
    const double* lin[4];
    Blocks at = now;
    for (int k = 0; k < 4; ++k) {
      const bool fixed = mask >> k & 1;
      lin[k] = fixed ? first[k].data() : nullptr;
      if (fixed) at[k] = first[k];
    }
    f.linearizeAt(lin[0], lin[1], lin[2], lin[3]);
    Eigen::VectorXd r, unused;
    const auto J = vir_test::analyticJacobians(f, now, &r);
    const auto expected = vir_test::analyticJacobians(plain, at, &unused);
    EXPECT_EQ(r, vir_test::residualOf(plain, now)) << "mask " << mask;
    for (int k = 0; k < 4; ++k) EXPECT_TRUE(J[k] == expected[k]) << "mask " << mask << " " << k;
  }
}

}  // namespace
}  // namespace vir::factors
