#include "vir/estimator/rest_detector.h"

#include <gtest/gtest.h>

namespace vir::estimator {
namespace {

constexpr TimeNs kMs = 1000000;

/// Thirty tracks on a grid, all shifted by `shift` pixels.
vision::TrackedFrame frameAt(TimeNs t, double shift, int tracks = 30) {
  vision::TrackedFrame f;
  f.t = t;
  for (int k = 0; k < tracks; ++k) {
    vision::FeatureObservation o;
    o.id = static_cast<std::uint64_t>(k + 1);
    o.px = Vec2(20 * k + shift, 100);
    f.features.push_back(o);
  }
  return f;
}

/// Three seconds of readings; `shake` is added with changing sign.
imu::ImuBuffer readings(double shake_gyro, double shake_acc) {
  imu::ImuBuffer b;
  for (int k = 0; k < 600; ++k) {
    const double s = k % 2 ? 1 : -1;
    b.add({k * 5 * kMs, Vec3(0.01 + s * shake_gyro, 0, 0), Vec3(0, 0, 9.81 + s * shake_acc)});
  }
  return b;
}

TEST(RestDetector, StandsOnceNothingMovedForLongEnough) {
  RestDetector d{RestOptions()};
  const imu::ImuBuffer imu = readings(0.001, 0.01);
  EXPECT_FALSE(d.update(frameAt(0, 0), imu)) << "nothing to compare with";
  EXPECT_FALSE(d.update(frameAt(200 * kMs, 0.1), imu)) << "0.2 s are too short";
  EXPECT_TRUE(d.update(frameAt(400 * kMs, 0.1), imu));
  EXPECT_TRUE(d.standing());
  EXPECT_EQ(d.since(), 0);
  EXPECT_TRUE(d.update(frameAt(2000 * kMs, 0.1), imu));
}

TEST(RestDetector, MotionEndsItAndStartsTheClockAgain) {
  RestDetector d{RestOptions()};
  const imu::ImuBuffer imu = readings(0.001, 0.01);
  d.update(frameAt(0, 0), imu);
  ASSERT_TRUE(d.update(frameAt(500 * kMs, 0), imu));
  EXPECT_FALSE(d.update(frameAt(600 * kMs, 1.0), imu));
  EXPECT_FALSE(d.standing());
  EXPECT_FALSE(d.update(frameAt(900 * kMs, 1.0), imu));
  EXPECT_TRUE(d.update(frameAt(1000 * kMs, 1.0), imu));
  EXPECT_EQ(d.since(), 600 * kMs);
}

TEST(RestDetector, SlowDriftIsMotionToo) {
  // 0.05 px per image: no image differs much from the last, all of them from the first.
  RestDetector d{RestOptions()};
  const imu::ImuBuffer imu = readings(0.001, 0.01);
  int standing = 0;
  for (int k = 0; k < 50; ++k) standing += d.update(frameAt(k * 50 * kMs, 0.05 * k), imu);
  EXPECT_LT(standing, 10);
}

TEST(RestDetector, VibrationIsNotRest) {
  for (const auto& [gyro, acc] : {std::pair(0.1, 0.0), std::pair(0.0, 1.0)}) {
    RestDetector d{RestOptions()};
    const imu::ImuBuffer imu = readings(gyro, acc);
    for (int k = 0; k < 20; ++k) EXPECT_FALSE(d.update(frameAt(k * 100 * kMs, 0), imu));
  }
}

/// A lift that sets off: the image moves along, the readings are quiet, their mean is not gravity.
TEST(RestDetector, WithAStateItIsHeldAgainstGravity) {
  const imu::ImuBuffer imu = readings(0.001, 0.01);
  RestDetector d{RestOptions()};
  RestDetector::Expected expected{Vec3(0.01, 0, 0), 9.81, true, false};
  d.setExpected(expected);
  d.update(frameAt(0, 0), imu);
  EXPECT_TRUE(d.update(frameAt(500 * kMs, 0), imu));
  expected.gravity_mps2 = 9.81 - 0.6;
  d.setExpected(expected);
  EXPECT_FALSE(d.update(frameAt(600 * kMs, 0), imu));
  expected.state_known = false;
  d.setExpected(expected);
  EXPECT_TRUE(d.update(frameAt(700 * kMs, 0), imu)) << "nothing is known of its bias";
}

TEST(RestDetector, WhatMovesDoesNotStandWhateverTheImageShows) {
  const imu::ImuBuffer imu = readings(0.001, 0.01);
  RestDetector d{RestOptions()};
  RestDetector::Expected expected{Vec3(0.01, 0, 0), 9.81, true, true};
  d.setExpected(expected);
  d.update(frameAt(0, 0), imu);
  EXPECT_FALSE(d.update(frameAt(500 * kMs, 0), imu));
  expected.moving = false;
  d.setExpected(expected);
  EXPECT_TRUE(d.update(frameAt(600 * kMs, 0), imu));
}

TEST(RestDetector, FewTracksAndUnusableImagesDecideNothing) {
  RestDetector d{RestOptions()};
  const imu::ImuBuffer imu = readings(0.001, 0.01);
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(d.update(frameAt(k * 100 * kMs, 0, 10), imu));
  d.update(frameAt(1000 * kMs, 0), imu);
  ASSERT_TRUE(d.update(frameAt(1500 * kMs, 0), imu));
  vision::TrackedFrame broken = frameAt(1600 * kMs, 0);
  broken.usable = false;
  EXPECT_FALSE(d.update(broken, imu));
  EXPECT_FALSE(d.standing());
  EXPECT_TRUE(d.update(frameAt(1700 * kMs, 0), imu)) << "the reference image is still good";
}

TEST(RestDetector, WithoutReadingsItDoesNotStand) {
  RestDetector d{RestOptions()};
  d.update(frameAt(0, 0), imu::ImuBuffer());
  EXPECT_FALSE(d.update(frameAt(1000 * kMs, 0), imu::ImuBuffer()));
}

TEST(RestDetector, ResetForgetsTheReference) {
  RestDetector d{RestOptions()};
  const imu::ImuBuffer imu = readings(0.001, 0.01);
  d.update(frameAt(0, 0), imu);
  ASSERT_TRUE(d.update(frameAt(500 * kMs, 0), imu));
  d.reset();
  EXPECT_FALSE(d.standing());
  EXPECT_FALSE(d.update(frameAt(600 * kMs, 0), imu));
}

}  // namespace
}  // namespace vir::estimator
