/// The splines pass through what they are given, and their derivatives are those of the curve.
#include "vir/geometry/spline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace {

using vir::expQuat;
using vir::logQuat;
using vir::Quat;
using vir::QuatList;
using vir::RotationSpline;
using vir::Vec3;
using vir::VectorSpline;

constexpr double kInterval = 0.1;

std::vector<Vec3> wavy(int n) {
  std::vector<Vec3> out;
  for (int k = 0; k < n; ++k) {
    const double t = kInterval * k;
    out.emplace_back(std::sin(2 * t), 0.3 * t * t, std::cos(3 * t) - t);
  }
  return out;
}

/// Large turns about changing axes, through half turns and back.
QuatList tumbling(int n) {
  QuatList out;
  for (int k = 0; k < n; ++k) {
    const double t = kInterval * k;
    out.push_back(expQuat(Vec3(2.5 * t, 0, 0)) * expQuat(Vec3(0, std::sin(3 * t), 0)) *
                  expQuat(Vec3(0, 0, -4 * t)));
  }
  return out;
}

TEST(VectorSpline, PassesThroughTheValues) {
  const auto values = wavy(30);
  const VectorSpline s = VectorSpline::through(kInterval, values);
  EXPECT_NEAR(s.duration(), kInterval * 29, 1e-12);
  for (int k = 0; k < 30; ++k) {
    const Vec3 error = s.at(kInterval * k).value - values[static_cast<std::size_t>(k)];
    EXPECT_LT(error.norm(), 1e-9) << "value " << k;
  }
}

TEST(VectorSpline, StraightLineStaysOne) {
  const VectorSpline s = VectorSpline::through(0.5, {{0, 0, 1}, {1, 2, 1}, {2, 4, 1}});
  const auto p = s.at(0.73);
  EXPECT_LT((p.value - Vec3(1.46, 2.92, 1)).norm(), 1e-12);
  EXPECT_LT((p.first - Vec3(2, 4, 0)).norm(), 1e-12);
  EXPECT_LT(p.second.norm(), 1e-10);
}

TEST(VectorSpline, DerivativesAreThoseOfTheCurve) {
  const VectorSpline s = VectorSpline::through(kInterval, wavy(30));
  constexpr double h = 1e-4;
  for (double t = 0.013; t < 2.8; t += 0.0317) {
    const auto p = s.at(t);
    EXPECT_LT(((s.at(t + h).value - s.at(t - h).value) / (2 * h) - p.first).norm(), 1e-6) << t;
    EXPECT_LT(((s.at(t + h).first - s.at(t - h).first) / (2 * h) - p.second).norm(), 5e-3) << t;
  }
}

TEST(VectorSpline, AccelerationHasNoSteps) {
  const VectorSpline s = VectorSpline::through(kInterval, wavy(30));
  for (int k = 1; k < 29; ++k) {
    const double t = kInterval * k;
    EXPECT_LT((s.at(t + 1e-9).second - s.at(t - 1e-9).second).norm(), 1e-5) << "knot " << k;
  }
}

TEST(RotationSpline, PassesThroughTheRotations) {
  const QuatList values = tumbling(40);
  const RotationSpline s = RotationSpline::through(kInterval, values);
  for (int k = 0; k < 40; ++k) {
    const Quat error = values[static_cast<std::size_t>(k)].conjugate() * s.at(kInterval * k).q_A_B;
    EXPECT_LT(logQuat(error).norm(), 1e-8) << "rotation " << k;
  }
}

TEST(RotationSpline, ConstantRateStaysConstant) {
  const Vec3 rate(0.3, -0.7, 1.1);
  QuatList values;
  for (int k = 0; k < 10; ++k) values.push_back(expQuat(rate * kInterval * k));
  const RotationSpline s = RotationSpline::through(kInterval, values);
  for (double t = 0; t <= s.duration(); t += 0.0123) {
    EXPECT_LT((s.at(t).rate_B - rate).norm(), 1e-9) << t;
    EXPECT_LT(s.at(t).acceleration_B.norm(), 1e-7) << t;
  }
}

TEST(RotationSpline, RatesAreThoseOfTheCurve) {
  const RotationSpline s = RotationSpline::through(kInterval, tumbling(40));
  constexpr double h = 1e-4;
  for (double t = 0.013; t < 3.8; t += 0.0317) {
    const auto p = s.at(t);
    const Vec3 rate = logQuat(s.at(t - h).q_A_B.conjugate() * s.at(t + h).q_A_B) / (2 * h);
    EXPECT_LT((rate - p.rate_B).norm(), 1e-5) << t;
    const Vec3 acceleration = (s.at(t + h).rate_B - s.at(t - h).rate_B) / (2 * h);
    EXPECT_LT((acceleration - p.acceleration_B).norm(), 3e-2) << t;
  }
}

TEST(Spline, RefusesWhatItCannotBe) {
  EXPECT_THROW(VectorSpline::through(0.1, {Vec3::Zero()}), std::invalid_argument);
  EXPECT_THROW(VectorSpline(0.1, {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}),
               std::invalid_argument);
  EXPECT_THROW(VectorSpline::through(0.0, wavy(5)), std::invalid_argument);
  EXPECT_THROW(RotationSpline::through(0.1, {Quat::Identity()}), std::invalid_argument);
  const VectorSpline s = VectorSpline::through(kInterval, wavy(5));
  EXPECT_THROW(s.at(-0.01), std::out_of_range);
  EXPECT_THROW(s.at(s.duration() + 0.01), std::out_of_range);
  EXPECT_THROW(s.at(std::nan("")), std::out_of_range);
}

}  // namespace
