/// Images that were taken at another time than their stamps say.
#include <gtest/gtest.h>

#include <cmath>

#include "vir/core/random.h"
#include "window_driver.h"

namespace vir::window {
namespace {

using vir_test::WindowDriver;

/// A window that has run for some seconds with stamps that are right.
void settle(WindowDriver* d) {
  d->start(d->scene.truth(d->t), StartPrior());
  for (int k = 0; k < 30; ++k) d->step(0.1);
}

TEST(StampNoise, AnImageTellsHowMuchLaterItWasTaken) {
  for (const double late_s : {-0.01, 0.0, 0.004, 0.01}) {
    WindowDriver d(vir_test::circling, 1, WindowOptions(), 0.8);
    settle(&d);
    const State from = d.window.newest();
    d.t += fromSeconds(0.05);
    d.feedImu();
    const imu::Preintegration link = d.imu.integrate(from.t, d.t, d.noise, from.bg, from.ba);
    const State s = predict(from, link, 9.81, d.t);
    d.camera_late_s = late_s;
    const Resected seen = d.window.resect(s.T_W_B, d.observe(), 1e9);
    ASSERT_TRUE(seen.late_s);
    EXPECT_NEAR(*seen.late_s, late_s, 0.0005);
  }
}

TEST(StampNoise, AnImageOfARobotAtRestTellsNoTime) {
  WindowDriver d(vir_test::still, 1, WindowOptions());
  d.start(d.scene.truth(d.t), StartPrior());
  d.push(0.1);
  EXPECT_FALSE(d.window.resect(d.window.newest().T_W_B, d.observe(), 1e9).late_s);
}

/// Distance to the truth over 20 s with stamps off by up to 10 ms, rms [m].
double errorWith(double stamp_sigma_s, unsigned seed) {
  WindowDriver d(vir_test::circling, seed, WindowOptions(), 0.8);
  settle(&d);
  d.window.setStampSigma(stamp_sigma_s);
  Random random(seed);
  double squares = 0;
  constexpr int kImages = 200;
  for (int k = 0; k < kImages; ++k) {
    d.camera_late_s = random.uniform(-0.01, 0.01);
    d.step(0.1);
    squares += std::pow(d.positionError(), 2) / kImages;
  }
  return std::sqrt(squares);
}

TEST(StampNoise, CostsLessWhereItIsKnown) {
  double unknown = 0, known = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    unknown += errorWith(0, seed) / 3;
    known += errorWith(0.006, seed) / 3;
  }
  std::printf("off by %.3f m, with the stamps' noise known by %.3f m\n", unknown, known);
  EXPECT_LT(known, 0.6 * unknown);
}

}  // namespace
}  // namespace vir::window
