#include "vir/estimator/rest_detector.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

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

/// Tracks all over the image with the noise of a good tracker; `at` says how far each has come.
vision::TrackedFrame noisyFrameAt(TimeNs t, std::mt19937* random,
                                  const std::function<Vec2(const Vec2&)>& at) {
  std::normal_distribution<double> noise(0, 0.05);
  vision::TrackedFrame f;
  f.t = t;
  for (int k = 0; k < 120; ++k) {
    vision::FeatureObservation o;
    o.id = static_cast<std::uint64_t>(k + 1);
    const Vec2 px(60.0 * (k % 12), 45.0 * (k / 12));
    o.px = px + at(px) + Vec2(noise(*random), noise(*random));
    f.features.push_back(o);
  }
  return f;
}

/// Half a minute of readings at rest.
imu::ImuBuffer longRest() {
  imu::ImuBuffer b;
  for (int k = 0; k < 6000; ++k) b.add({k * 5 * kMs, Vec3(0.01, 0, 0), Vec3(0, 0, 9.81)});
  return b;
}

/// Share of 29 s of images in which it stands.
double shareStanding(const std::function<Vec2(double, const Vec2&)>& at, bool held = true) {
  RestDetector d{RestOptions()};
  d.setExpected({Vec3(0.01, 0, 0), 9.81, true, false, held});
  const imu::ImuBuffer imu = longRest();
  std::mt19937 random(7);
  int standing = 0;
  constexpr int kImages = 29 * 20;
  for (int k = 0; k < kImages; ++k) {
    const double t = 0.05 * k;
    standing += d.update(
        noisyFrameAt(k * 50 * kMs, &random, [&](const Vec2& px) { return at(t, px); }), imu);
  }
  return standing / static_cast<double>(kImages);
}

TEST(RestDetector, ACreepFarBelowTheNoiseOfATrackIsNoRest) {
  EXPECT_GT(shareStanding([](double, const Vec2&) { return Vec2(0, 0); }), 0.95);
  // Sideways by 0.1 px/s, and straight ahead: 0.1 px/s at the border.
  EXPECT_LT(shareStanding([](double t, const Vec2&) { return Vec2(0.1 * t, 0); }), 0.1);
  EXPECT_LT(shareStanding([](double t, const Vec2& px) {
              return Vec2(0.1 * t * (px - Vec2(360, 240)) / 360);
            }),
            0.2);
  // Sideways over ground that lies before it: the nearer, the faster.
  EXPECT_LT(shareStanding(
                [](double t, const Vec2& px) { return Vec2(0.1 * t * (px.y() - 200) / 200, 0); }),
            0.2);
  // Where no landmark holds the pose, a rest that is none is the lesser evil.
  EXPECT_GT(shareStanding([](double t, const Vec2&) { return Vec2(0.1 * t, 0); }, false), 0.7);
}

/// A twelfth of the tracks has come by 0.4 px and stays there: a thing, not the camera.
TEST(RestDetector, AThingThatHasMovedIsNoMotionOfTheCamera) {
  EXPECT_GT(shareStanding(
                [](double t, const Vec2& px) { return Vec2(t > 0 && px.x() > 650 ? 0.4 : 0, 0); }),
            0.9);
}

/// Each proof that it was none asks for a longer one; a real motion ends that.
TEST(RestDetector, AfterAMotionTheShortestRestIsEnoughAgain) {
  RestDetector d{RestOptions()};
  d.setExpected({Vec3(0.01, 0, 0), 9.81, true, false, true});
  const imu::ImuBuffer imu = longRest();
  std::mt19937 random(7);
  const auto shifted = [&](double t, double by) {
    return d.update(
        noisyFrameAt(fromSeconds(t), &random, [by](const Vec2&) { return Vec2(by, 0); }), imu);
  };
  shifted(0, 0);
  ASSERT_TRUE(shifted(0.5, 0));
  ASSERT_FALSE(shifted(1.0, 0.2)) << "it has crept by 0.2 px";
  EXPECT_FALSE(shifted(1.5, 0.2)) << "now 0.8 s are asked for";
  EXPECT_TRUE(shifted(1.85, 0.2));
  ASSERT_FALSE(shifted(2.0, 5)) << "it moves";
  EXPECT_TRUE(shifted(2.45, 5));
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
  RestDetector::Expected expected{Vec3(0.01, 0, 0), 9.81, true, false, false};
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
  RestDetector::Expected expected{Vec3(0.01, 0, 0), 9.81, true, true, false};
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
