/// Numbers that are no measurements: no answer, or one of numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>

#include "simulated_frames.h"
#include "vir/initialization/image_turn.h"
#include "vir_test_extremes.h"

namespace vir::initialization {
namespace {

using vir_test::framesOf;
using vir_test::Scene;
using Frames = std::vector<AlignmentFrame>;

Frames good() {
  Scene scene(vir_test::circling, 1, 120);
  return framesOf(scene, 1, 6, 0.2, Vec3::Zero());
}

/// Bearings of one sight, and of all sights of an image.
void forSpoiltFrames(const std::function<void(const Frames&)>& tried) {
  const Frames frames = good();
  test::forExtremeVectors(frames[2].sights[3].bearing, [&](const Vec3& bearing) {
    SCOPED_TRACE(testing::Message() << bearing.transpose());
    Frames one = frames, all = frames;
    one[2].sights[3].bearing = bearing;
    for (AlignmentSight& s : all[2].sights) s.bearing = bearing;
    tried(one);
    tried(all);
  });
}

void expectNumbersOrNothing(const GyroBiasEstimate& e) {
  if (!e.ok) return;
  EXPECT_TRUE(e.bias.allFinite() && std::isfinite(e.rms_px));
}

void expectNumbersOrNothing(const InertialAlignment& a) {
  if (!a.ok) return;
  EXPECT_TRUE(a.g_B0.allFinite() && std::isfinite(a.residual_px));
  for (std::size_t k = 0; k < a.p_B0.size(); ++k) {
    EXPECT_TRUE(a.p_B0[k].allFinite() && a.v_B0[k].allFinite() && a.q_B0_B[k].coeffs().allFinite());
  }
}

TEST(ExtremeNumbers, BearingsOfAStart) {
  forSpoiltFrames([&](const Frames& frames) {
    expectNumbersOrNothing(estimateGyroBias(frames, Scene::T_B_C().q, Scene::kFocal, Vec3::Zero()));
    expectNumbersOrNothing(alignInertial(frames, Scene::T_B_C(), 9.81, Scene::kFocal));
    for (const auto& turn :
         {turnBetween(frames[1].t, frames[1].sights, frames[2].t, frames[2].sights, Scene::kFocal),
          turnBetween(frames[2].t, frames[2].sights, frames[3].t, frames[3].sights,
                      Scene::kFocal)}) {
      EXPECT_TRUE(!turn || (turn->rate_C.allFinite() && turn->information.allFinite()));
    }
  });
}

TEST(ExtremeNumbers, WhatIsGivenToAStart) {
  const Frames frames = good();
  for (const double x : test::extremes()) {
    SCOPED_TRACE(x);
    expectNumbersOrNothing(estimateGyroBias(frames, Scene::T_B_C().q, x, Vec3::Zero()));
    expectNumbersOrNothing(
        estimateGyroBias(frames, Scene::T_B_C().q, Scene::kFocal, Vec3(x, 0.1, -x)));
    expectNumbersOrNothing(alignInertial(frames, Scene::T_B_C(), x, Scene::kFocal));
    expectNumbersOrNothing(alignInertial(frames, Scene::T_B_C(), 9.81, x));
    expectNumbersOrNothing(
        alignInertial(frames, {Scene::T_B_C().q, Vec3(0, x, 0.1)}, 9.81, Scene::kFocal));
    const auto turn = turnBetween(frames[1].t, frames[1].sights, frames[2].t, frames[2].sights, x);
    EXPECT_TRUE(!turn || (turn->rate_C.allFinite() && turn->information.allFinite()));
  }
}

/// Stamps of an image, the extremes of 64 bits among them.
TEST(ExtremeNumbers, StampsOfTurns) {
  const Frames frames = good();
  const std::vector<TimeNs> stamps{INT64_MIN, -1, 0, 1, INT64_MAX};
  for (const TimeNs t0 : stamps) {
    for (const TimeNs t1 : stamps) {
      const auto turn = turnBetween(t0, frames[1].sights, t1, frames[2].sights, Scene::kFocal);
      EXPECT_TRUE(!turn || (turn->rate_C.allFinite() && turn->information.allFinite()))
          << t0 << " to " << t1;
    }
  }
}

/// Ten seconds of turning about changing axes; readings and images agree.
struct Turning {
  std::vector<ImageTurn> turns;
  std::vector<ImuSample> readings;
  Turning() {
    for (int k = 0; k < 2000; ++k) {
      const double s = 0.005 * k;
      readings.push_back({fromSeconds(s), rate(s), Vec3(0, 0, 9.81)});
    }
    for (int k = 4; k < 190; ++k) {
      const double s = 0.05 * k;
      turns.push_back(
          {fromSeconds(s), fromSeconds(s + 0.1), rate(s + 0.05), 1e4 * Mat3::Identity()});
    }
  }
  static Vec3 rate(double s) {
    return {std::sin(2 * s), 0.7 * std::cos(3 * s), 0.5 * std::sin(1.3 * s)};
  }
  void expectNumbersOrNothing() const {
    imu::ImuBuffer imu;
    for (const ImuSample& r : readings) imu.add(r);
    const TurnCorrelation c = correlateTurns(turns, imu, Quat::Identity());
    EXPECT_TRUE(!c.ok || (std::isfinite(c.offset_s) && std::isfinite(c.sigma_s) &&
                          std::isfinite(c.explained) && std::isfinite(c.against_none) &&
                          c.gyro_bias.allFinite()));
    const CameraRotation r = findCameraRotation(turns, imu);
    EXPECT_TRUE(!r.ok || (r.q_B_C.coeffs().allFinite() && std::isfinite(r.offset_s) &&
                          std::isfinite(r.sigma_rad) && std::isfinite(r.explained)));
  }
};

TEST(ExtremeNumbers, TurnsAndReadings) {
  const Turning whole;
  whole.expectNumbersOrNothing();
  for (const double x : test::extremes()) {
    SCOPED_TRACE(x);
    Turning rate = whole, information = whole, reading = whole, all = whole;
    rate.turns[50].rate_C = Vec3(0.1, x, 0);
    information.turns[50].information(1, 1) = x;
    reading.readings[700].gyro.z() = x;
    for (ImageTurn& t : all.turns) t.rate_C *= x;
    for (const Turning& spoilt : {rate, information, reading, all}) {
      spoilt.expectNumbersOrNothing();
    }
  }
}

}  // namespace
}  // namespace vir::initialization
