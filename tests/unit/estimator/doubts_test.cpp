/// Each doubt of a run: raised where it must be, not where it must not, and what it names.
#include "doubts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vir::estimator {
namespace {

constexpr TimeNs kImage = 50000000;  // 20 Hz
const Evidence kKeyframe{true, false}, kBetween{false, false}, kBlind{true, true};

/// Of a good recording in motion.
StateEstimate good(int image) {
  StateEstimate e;
  e.state.t = 1000000000 + image * kImage;
  e.valid = true;
  e.health = Health::ok;
  e.tracks = 150;
  e.landmarks = 120;
  e.state.v = Vec3(1, 0, 0);
  e.state.T_W_B.p = Vec3(0.05 * image, 0, 0);
  e.reprojection_rms = 1.1;
  e.inertial_rms = 0.6;
  return e;
}

/// `images` estimates that `change` alters; the last word on them.
Doubts watched(int images, const std::function<void(int, StateEstimate*)>& change,
               const Evidence& evidence = kKeyframe) {
  Doubts doubts;
  for (int i = 0; i < images; ++i) {
    StateEstimate e = good(i);
    change(i, &e);
    doubts.look(e, evidence);
  }
  return doubts;
}

bool names(const Doubts& doubts, const std::string& part) {
  return doubts.all().size() == 1 && doubts.all()[0].find(part) != std::string::npos;
}

TEST(Doubts, NoneOfAGoodRun) {
  const Doubts d = watched(600, [](int i, StateEstimate* e) {
    e->inertial_rms += 0.2 * std::sin(i);
    e->reprojection_rms += 0.1 * std::cos(i);
    e->landmarks -= i % 50;
    e->state.ba = Vec3(0.3, -0.2, 0.1);
  });
  EXPECT_EQ(d.current(), "");
  EXPECT_TRUE(d.all().empty());
}

/// In a lift the readings rise and the images do not.
TEST(Doubts, VelocityAgainstPositions) {
  const auto rising = [](double seen_mps, double felt_mps) {
    return watched(200, [=](int i, StateEstimate* e) {
      e->state.T_W_B.p = Vec3(0, 0, seen_mps * 0.05 * i);
      e->state.v = Vec3(0, 0, felt_mps);
    });
  };
  EXPECT_TRUE(rising(0, 0.28).all().empty());
  EXPECT_TRUE(rising(3, 3.5).all().empty()) << "a wrong scale is another matter";
  const Doubts lift = rising(0, 0.5);
  EXPECT_TRUE(names(lift, "m/s against what is seen"));
  EXPECT_NE(lift.current(), "");
  EXPECT_TRUE(names(rising(1, 0), "against what is seen"));
}

TEST(Doubts, AGainFarBeyondItsPrior) {
  const auto with_gain = [](double sigmas) {
    return watched(10, [](int, StateEstimate*) {}, {true, false, sigmas});
  };
  EXPECT_TRUE(with_gain(5.9).all().empty());
  EXPECT_TRUE(names(with_gain(6.1), "accelerometer's gain"));
}

TEST(Doubts, ReadingsAgainstImages) {
  const auto level = [](double mean_square) {
    return watched(100, [=](int, StateEstimate* e) { e->inertial_rms = std::sqrt(mean_square); });
  };
  EXPECT_TRUE(level(1.4).all().empty());
  const Doubts d = level(1.6);
  EXPECT_TRUE(names(d, "readings of the IMU do not fit the images (1.3 sigma)"));
  EXPECT_TRUE(names(d, "units or axes")) << "what may be the cause";
  EXPECT_FALSE(d.current().empty());
}

TEST(Doubts, SightsAgainstEachOther) {
  const auto level = [](double mean_square, const Evidence& evidence) {
    return watched(
        100, [=](int, StateEstimate* e) { e->reprojection_rms = std::sqrt(mean_square); },
        evidence);
  };
  EXPECT_TRUE(level(2.4, kKeyframe).all().empty());
  const Doubts d = level(2.8, kKeyframe);
  EXPECT_TRUE(names(d, "sights contradict each other (1.7 sigma)"));
  EXPECT_TRUE(names(d, "calibration of the camera, its clock, or things that move"));
  EXPECT_TRUE(level(9, kBetween).all().empty()) << "the newest frame alone is no level";
}

TEST(Doubts, OneBadSolutionIsNoLevelAndFewAreNone) {
  const auto wrong = [](int from, int to) {
    return [=](int i, StateEstimate* e) {
      if (i >= from && i < to) e->inertial_rms = e->reprojection_rms = 1000;
    };
  };
  EXPECT_TRUE(watched(200, wrong(100, 101)).all().empty());
  EXPECT_TRUE(watched(7, wrong(0, 7)).all().empty()) << "too few keyframes to tell";
  EXPECT_EQ(watched(9, wrong(0, 9)).all().size(), 2u);
  EXPECT_EQ(watched(200, wrong(100, 110)).all().size(), 2u);
}

TEST(Doubts, AreToldOnceWithTheirTimeAndEndWithTheirCause) {
  const Doubts d = watched(400, [](int i, StateEstimate* e) {
    if (i >= 100 && i < 150) e->inertial_rms = 3;
    if (i >= 250 && i < 300) e->inertial_rms = 3;
  });
  EXPECT_EQ(d.current(), "") << "it is over";
  ASSERT_EQ(d.all().size(), 1u);
  const double from = std::stod(d.all()[0].substr(d.all()[0].find("(from ") + 6));
  EXPECT_GT(from, 6.0) << "the cause began at 6.0 s";
  EXPECT_LT(from, 6.5);
}

TEST(Doubts, FewTracksAreLandmarks) {
  const auto seen = [](int landmarks, Health health) {
    return watched(100, [=](int, StateEstimate* e) {
      e->landmarks = landmarks;
      e->health = health;
    });
  };
  EXPECT_TRUE(seen(20, Health::ok).all().empty());
  EXPECT_TRUE(names(seen(15, Health::ok), "few tracks fit the motion: 15 landmarks of 150 tracks"));
  EXPECT_TRUE(seen(0, Health::standing).all().empty()) << "at rest no depth is needed";
  EXPECT_TRUE(watched(60,
                      [](int, StateEstimate* e) {
                        e->landmarks = 0;
                        e->state.v = Vec3(0.05, 0, 0);
                        e->state.T_W_B.p.setZero();
                      })
                  .all()
                  .empty())
      << "nor before it moves";
  EXPECT_TRUE(watched(100,
                      [](int, StateEstimate* e) {
                        e->tracks = 20;  // dark, not wrong
                        e->landmarks = 0;
                      })
                  .all()
                  .empty());
  EXPECT_TRUE(watched(39, [](int, StateEstimate* e) { e->landmarks = 0; }).all().empty())
      << "just after the start";
}

TEST(Doubts, BiasesThatAreNotPlausible) {
  const auto bias = [](double acc, double gyro) {
    return watched(1, [=](int, StateEstimate* e) {
      e->state.ba = Vec3(0, acc, 0);
      e->state.bg = Vec3(0, 0, gyro);
    });
  };
  EXPECT_TRUE(bias(1.1, 0.25).all().empty());
  EXPECT_TRUE(names(bias(1.3, 0), "accelerometer bias of 1.3 m/s^2"));
  EXPECT_TRUE(names(bias(1.3, 0), "units, axes or calibration"));
  EXPECT_TRUE(names(bias(0, 0.35), "gyro bias of 0.35 rad/s"));
  EXPECT_EQ(bias(1.3, 0.35).all().size(), 2u);
}

TEST(Doubts, ReadingsAloneForLong) {
  const auto blind = [](int images, Health health) {
    return watched(
        images, [=](int, StateEstimate* e) { e->health = health; }, kBlind);
  };
  const Doubts brief = blind(20, Health::ok);
  EXPECT_TRUE(brief.all().empty()) << "short blindness is no doubt of the run";
  EXPECT_EQ(brief.current(), "no landmarks, IMU only") << "but of the frame";
  EXPECT_TRUE(names(blind(60, Health::ok), "no landmarks for 1.6 s, IMU only"));
  EXPECT_EQ(blind(60, Health::standing).current(), "") << "at rest the images hold it";
}

TEST(Doubts, ARestartStaysAndTheLevelsBeginAnew) {
  Doubts d;
  for (int i = 0; i < 50; ++i) {
    StateEstimate e = good(i);
    e.inertial_rms = 3;
    d.look(e, kKeyframe);
  }
  d.restarted(good(50).state.t, "implausible speed");
  for (int i = 51; i < 100; ++i) d.look(good(i), kKeyframe);
  EXPECT_EQ(d.current(), "");
  ASSERT_EQ(d.all().size(), 2u);
  EXPECT_NE(d.all()[1].find("started anew on the way (implausible speed)"), std::string::npos);
  EXPECT_NE(d.all()[1].find("from 3.5 s on"), std::string::npos) << d.all()[1];
}

TEST(Doubts, WhatOthersFindIsToldOncePerKind) {
  Doubts d;
  d.add("clock", 2000000000, "the images seem 30 ms late");
  d.add("clock", 3000000000, "the images seem 31 ms late");
  d.add("turned", 4000000000, "the camera seems turned by 90 deg");
  ASSERT_EQ(d.all().size(), 2u);
  EXPECT_EQ(d.all()[0], "the images seem 30 ms late (from 2.0 s on)");
  EXPECT_EQ(d.all()[1], "the camera seems turned by 90 deg (from 4.0 s on)");
}

}  // namespace
}  // namespace vir::estimator
