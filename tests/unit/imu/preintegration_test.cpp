#include "vir/imu/preintegration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace vir::imu {
namespace {

using Signal = std::function<Vec3(double)>;  // of time [s]

ImuSample sample(const Signal& gyro, const Signal& acc, double t) {
  return {fromSeconds(t), gyro(t), acc(t)};
}

Preintegration preintegrate(const Signal& gyro, const Signal& acc, double from, double to,
                            const Vec3& bg, const Vec3& ba, double rate_hz = 200) {
  Preintegration p(ImuNoise(), bg, ba);
  const int n = static_cast<int>(std::lround((to - from) * rate_hz));
  for (int k = 0; k < n; ++k) {
    p.integrate(sample(gyro, acc, from + k / rate_hz), sample(gyro, acc, from + (k + 1) / rate_hz));
  }
  return p;
}

struct Motion {
  Quat q = Quat::Identity();
  Vec3 p = Vec3::Zero(), v = Vec3::Zero();
};

/// The same integral by fourth-order Runge-Kutta with tiny steps: error far below 1e-9.
Motion reference(const Signal& gyro, const Signal& acc, double from, double to) {
  const int n = 4000;
  const double h = (to - from) / n;
  Motion m;
  const auto rate = [&](const Quat& q, double t) {
    const Vec3 w = 0.5 * gyro(t);
    return Eigen::Vector4d((q * Quat(0, w.x(), w.y(), w.z())).coeffs());
  };
  const auto at = [](const Quat& q, const Eigen::Vector4d& d) {
    Quat r;
    r.coeffs() = q.coeffs() + d;
    return r;
  };
  for (int k = 0; k < n; ++k) {
    const double t = from + k * h;
    const Eigen::Vector4d k1 = rate(m.q, t), k2 = rate(at(m.q, h / 2 * k1), t + h / 2),
                          k3 = rate(at(m.q, h / 2 * k2), t + h / 2),
                          k4 = rate(at(m.q, h * k3), t + h);
    const Quat mid = at(m.q, h / 2 * k2).normalized();
    const Quat end = at(m.q, h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)).normalized();
    const Vec3 a0 = m.q * acc(t), am = mid * acc(t + h / 2), a1 = end * acc(t + h);
    m.p += h * m.v + h * h / 6 * (a0 + 2 * am);  // Simpson's rule for the double integral
    m.v += h / 6 * (a0 + 4 * am + a1);
    m.q = end;
  }
  return m;
}

const Signal kSlowGyro = [](double t) {
  return Vec3(0.6 * std::sin(2 * t), 0.4 * std::cos(3 * t), 0.5 + 0.3 * std::sin(t));
};
const Signal kSlowAcc = [](double t) {
  return Vec3(2 * std::sin(3 * t), 1.5 * std::cos(2 * t), 9.81 + std::sin(4 * t));
};

TEST(Preintegration, StraightMotionIsExact) {
  // a = 2 m/s^2 for 1 s: v = 2 m/s, p = 1 m; no rotation.
  const Preintegration p =
      preintegrate([](double) { return Vec3::Zero(); }, [](double) { return Vec3(2, 0, 0); }, 0, 1,
                   Vec3::Zero(), Vec3::Zero());
  EXPECT_LT((p.dp() - Vec3(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((p.dv() - Vec3(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT(p.dq().angularDistance(Quat::Identity()), 1e-15);
  EXPECT_NEAR(p.dt(), 1, 1e-12);
  EXPECT_EQ(p.size(), 200u);
}

TEST(Preintegration, ConstantRateAndBodyAcceleration) {
  // Circle: w about z, a along x of the body. v = a/w (sin wt, 1 - cos wt),
  // p = a/w^2 (1 - cos wt, wt - sin wt). The trapezoid's relative error is (w dt)^2/12 = 5e-6.
  const double w = 1.5, a = 3, t = 1;
  const Preintegration p =
      preintegrate([&](double) { return Vec3(0, 0, w); }, [&](double) { return Vec3(a, 0, 0); }, 0,
                   t, Vec3::Zero(), Vec3::Zero());
  EXPECT_LT(p.dq().angularDistance(expQuat(Vec3(0, 0, w * t))), 1e-7);
  const Vec3 v(a / w * std::sin(w * t), a / w * (1 - std::cos(w * t)), 0);
  const Vec3 x(a / (w * w) * (1 - std::cos(w * t)), a / (w * w) * (w * t - std::sin(w * t)), 0);
  EXPECT_LT((p.dv() - v).norm(), 2e-5);
  EXPECT_LT((p.dp() - x).norm(), 2e-5);
}

TEST(Preintegration, SinusoidalMotionAgainstFineIntegration) {
  const Preintegration p = preintegrate(kSlowGyro, kSlowAcc, 0, 1, Vec3::Zero(), Vec3::Zero());
  const Motion m = reference(kSlowGyro, kSlowAcc, 0, 1);
  EXPECT_LT(p.dq().angularDistance(m.q), 2e-5);
  EXPECT_LT((p.dv() - m.v).norm(), 2e-4);
  EXPECT_LT((p.dp() - m.p).norm(), 2e-4);
}

TEST(Preintegration, IsOfSecondOrderInTheStep) {
  const Motion m = reference(kSlowGyro, kSlowAcc, 0, 1);
  const auto error = [&](double rate) {
    return (preintegrate(kSlowGyro, kSlowAcc, 0, 1, Vec3::Zero(), Vec3::Zero(), rate).dp() - m.p)
        .norm();
  };
  EXPECT_NEAR(error(100) / error(200), 4, 0.6);
}

TEST(Preintegration, BiasIsTakenOffTheReadings) {
  const Vec3 bg(0.05, -0.03, 0.02), ba(0.2, -0.1, 0.3);
  const Preintegration biased =
      preintegrate([&](double t) { return Vec3(kSlowGyro(t) + bg); },
                   [&](double t) { return Vec3(kSlowAcc(t) + ba); }, 0, 1, bg, ba);
  const Preintegration clean = preintegrate(kSlowGyro, kSlowAcc, 0, 1, Vec3::Zero(), Vec3::Zero());
  EXPECT_LT((biased.dp() - clean.dp()).norm(), 1e-12);
  EXPECT_LT((biased.dv() - clean.dv()).norm(), 1e-12);
  EXPECT_LT(biased.dq().angularDistance(clean.dq()), 1e-12);
}

TEST(Preintegration, BiasJacobianIsTheDerivativeOfReintegration) {
  const Vec3 bg(0.01, 0.02, -0.01), ba(0.1, -0.2, 0.05);
  const Preintegration p = preintegrate(kSlowGyro, kSlowAcc, 0, 1, bg, ba);
  const double h = 1e-5;
  for (int k = 0; k < 6; ++k) {
    const Vec3 dg = k < 3 ? Vec3(h * Vec3::Unit(k)) : Vec3::Zero();
    const Vec3 da = k < 3 ? Vec3::Zero() : Vec3(h * Vec3::Unit(k - 3));
    const Preintegration up = preintegrate(kSlowGyro, kSlowAcc, 0, 1, bg + dg, ba + da);
    const Preintegration down = preintegrate(kSlowGyro, kSlowAcc, 0, 1, bg - dg, ba - da);
    Eigen::Matrix<double, 9, 1> numeric;
    numeric << (up.dp() - down.dp()) / (2 * h),
        (logQuat(p.dq().conjugate() * up.dq()) - logQuat(p.dq().conjugate() * down.dq())) / (2 * h),
        (up.dv() - down.dv()) / (2 * h);
    EXPECT_LT((p.biasJacobian().col(k) - numeric).norm(), 1e-7)
        << "column " << k << "\nanalytic " << p.biasJacobian().col(k).transpose() << "\nnumeric  "
        << numeric.transpose();
  }
}

TEST(Preintegration, IntrinsicsJacobianIsTheDerivativeOfReintegration) {
  const Vec3 bg(0.01, 0.02, -0.01), ba(0.1, -0.2, 0.05);
  ImuIntrinsics at;
  at << 0.01, -0.02, 0.005, 0.008, -0.01, 0.004, -0.01, 0.006, 0.012;
  Preintegration p = preintegrate(kSlowGyro, kSlowAcc, 0, 1, bg, ba);
  p.relinearise(bg, ba, at);
  const double h = 1e-5;
  for (int k = 0; k < 9; ++k) {
    Preintegration up = p, down = p;
    up.relinearise(bg, ba, at + h * ImuIntrinsics::Unit(k));
    down.relinearise(bg, ba, at - h * ImuIntrinsics::Unit(k));
    Eigen::Matrix<double, 9, 1> numeric;
    numeric << (up.dp() - down.dp()) / (2 * h),
        (logQuat(p.dq().conjugate() * up.dq()) - logQuat(p.dq().conjugate() * down.dq())) / (2 * h),
        (up.dv() - down.dv()) / (2 * h);
    EXPECT_LT((p.intrinsicsJacobian().col(k) - numeric).norm(), 1e-7)
        << "column " << k << "\nanalytic " << p.intrinsicsJacobian().col(k).transpose()
        << "\nnumeric  " << numeric.transpose();
  }
}

TEST(Preintegration, IntrinsicsByHand) {
  // Turning at 1 rad/s about z as read, accelerating at 2 m/s^2 along z: the axis stays.
  Preintegration p(ImuNoise(), Vec3::Zero(), Vec3::Zero());
  for (int k = 0; k < 20; ++k) {
    p.integrate({k * 5000000LL, Vec3(0, 0, 1), Vec3(0, 0, 2)},
                {(k + 1) * 5000000LL, Vec3(0, 0, 1), Vec3(0, 0, 2)});
  }
  ImuIntrinsics gains = ImuIntrinsics::Zero();
  gains[kGyroGain + 2] = 0.02;  // 0.1 s at 1.02 rad/s
  gains[kAccGain + 2] = -0.5;   // 0.1 s at 1 m/s^2
  p.relinearise(Vec3::Zero(), Vec3::Zero(), gains);
  EXPECT_NEAR(logQuat(p.dq()).z(), 0.102, 1e-12);
  EXPECT_NEAR(p.dv().z(), 0.1, 1e-12);
  EXPECT_NEAR(p.lastRate().z(), 1.02, 1e-12);
  ImuIntrinsics axes = ImuIntrinsics::Zero();
  axes[kGyroAxes] = 0.1;  // about x: (0.1, 0, 0) x (0, 0, 1) = (0, -0.1, 0)
  p.relinearise(Vec3::Zero(), Vec3::Zero(), axes);
  EXPECT_NEAR(p.firstRate().y(), -0.1, 1e-12);
  EXPECT_NEAR(p.firstRate().z(), 1, 1e-12);
}

TEST(Preintegration, CorrectedValuesFollowReintegrationToFirstOrder) {
  const Vec3 dg(1e-3, -2e-3, 1e-3), da(0.02, 0.01, -0.03);
  const Preintegration p = preintegrate(kSlowGyro, kSlowAcc, 0, 0.5, Vec3::Zero(), Vec3::Zero());
  const Preintegration moved = preintegrate(kSlowGyro, kSlowAcc, 0, 0.5, dg, da);
  // The change is of order 5e-3; what first order leaves is of order 1e-5.
  EXPECT_GT((moved.dp() - p.dp()).norm(), 2e-3);
  EXPECT_LT((p.correctedDp(dg, da) - moved.dp()).norm(), 1e-5);
  EXPECT_LT((p.correctedDv(dg, da) - moved.dv()).norm(), 3e-5);
  EXPECT_LT(p.correctedDq(dg).angularDistance(moved.dq()), 2e-6);
}

TEST(Preintegration, RelineariseEqualsIntegratingWithTheNewBiases) {
  const Vec3 bg(0.01, 0.02, -0.01), ba(0.1, -0.2, 0.05);
  Preintegration p = preintegrate(kSlowGyro, kSlowAcc, 0, 0.5, Vec3::Zero(), Vec3::Zero());
  p.relinearise(bg, ba, ImuIntrinsics::Zero());
  const Preintegration direct = preintegrate(kSlowGyro, kSlowAcc, 0, 0.5, bg, ba);
  EXPECT_EQ(p.biasGyro(), bg);
  EXPECT_EQ(p.biasAcc(), ba);
  EXPECT_EQ(p.dp(), direct.dp());
  EXPECT_EQ(p.dv(), direct.dv());
  EXPECT_EQ(p.dq().coeffs(), direct.dq().coeffs());
  EXPECT_EQ(p.biasJacobian(), direct.biasJacobian());
  EXPECT_EQ(p.covariance(), direct.covariance());
  EXPECT_EQ(p.dt(), direct.dt());
}

TEST(Preintegration, AppendEqualsOnePass) {
  Preintegration first = preintegrate(kSlowGyro, kSlowAcc, 0, 0.3, Vec3::Zero(), Vec3::Zero());
  first.append(preintegrate(kSlowGyro, kSlowAcc, 0.3, 0.5, Vec3::Zero(), Vec3::Zero()));
  const Preintegration whole =
      preintegrate(kSlowGyro, kSlowAcc, 0, 0.5, Vec3::Zero(), Vec3::Zero());
  EXPECT_LT((first.dp() - whole.dp()).norm(), 1e-13);
  EXPECT_LT((first.dv() - whole.dv()).norm(), 1e-13);
  EXPECT_LT(first.dq().angularDistance(whole.dq()), 1e-13);
  EXPECT_LT((first.covariance() - whole.covariance()).norm(), 1e-15);
  EXPECT_LT((first.biasJacobian() - whole.biasJacobian()).norm(), 1e-12);
  EXPECT_EQ(first.size(), whole.size());
  EXPECT_NEAR(first.dt(), 0.5, 1e-12);
}

TEST(Preintegration, AppendUsesItsOwnBiasesForWhatFollows) {
  const Vec3 bg(0.01, 0.02, -0.01), ba(0.1, -0.2, 0.05);
  Preintegration first = preintegrate(kSlowGyro, kSlowAcc, 0, 0.3, bg, ba);
  first.append(preintegrate(kSlowGyro, kSlowAcc, 0.3, 0.5, Vec3::Zero(), Vec3::Zero()));
  const Preintegration whole = preintegrate(kSlowGyro, kSlowAcc, 0, 0.5, bg, ba);
  EXPECT_LT((first.dp() - whole.dp()).norm(), 1e-13);
}

TEST(Preintegration, RefusesUnusableReadings) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const ImuSample a{0, Vec3::Zero(), Vec3(0, 0, 9.81)}, b{5000000, Vec3::Zero(), Vec3(0, 0, 9.81)};
  Preintegration p(ImuNoise(), Vec3::Zero(), Vec3::Zero());
  EXPECT_THROW(p.integrate(b, a), std::invalid_argument);  // reversed
  EXPECT_THROW(p.integrate(a, a), std::invalid_argument);  // equal
  for (double bad : {nan, inf}) {
    for (int which = 0; which < 4; ++which) {
      ImuSample x = a, y = b;
      (which == 0 ? x.gyro : which == 1 ? x.acc : which == 2 ? y.gyro : y.acc)[1] = bad;
      EXPECT_THROW(p.integrate(x, y), std::invalid_argument) << which;
    }
  }
  EXPECT_EQ(p.size(), 0u) << "what was refused must not be kept";
  EXPECT_EQ(p.dt(), 0);
  p.integrate(a, b);
  EXPECT_EQ(p.size(), 1u);
}

TEST(Preintegration, ASingleStepHasAnInvertibleCovariance) {
  Preintegration p(ImuNoise(), Vec3::Zero(), Vec3::Zero());
  p.integrate({0, Vec3::Zero(), Vec3(0, 0, 9.81)}, {5000000, Vec3::Zero(), Vec3(0, 0, 9.81)});
  const Mat15 S = p.sqrtInformation();
  EXPECT_TRUE(S.allFinite());
  EXPECT_LT((S * p.covariance() * S.transpose() - Mat15::Identity()).norm(), 1e-6);
}

TEST(Preintegration, WithoutReadingsThereIsNoInformation) {
  const Preintegration p(ImuNoise(), Vec3::Zero(), Vec3::Zero());
  EXPECT_THROW(p.sqrtInformation(), std::runtime_error);
}

}  // namespace
}  // namespace vir::imu
