/// Settings that are refused before anything runs, rule by rule.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "vir/estimator/odometry_range_estimator.h"
#include "vir/estimator/visual_inertial_estimator.h"

namespace vir::estimator {
namespace {

template <typename Options>
std::string refusalOf(const Options& options) {
  try {
    options.validate();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return {};
}

/// The message names the section, the key with its value, and what is allowed.
void expectRefused(const std::string& message, const std::string& setting,
                   const std::string& allowed) {
  EXPECT_EQ(message.rfind(setting, 0), 0u) << "'" << message << "' does not begin with " << setting;
  const std::size_t at = message.find("allowed: ");
  ASSERT_NE(at, std::string::npos) << message;
  EXPECT_NE(message.find(allowed, at), std::string::npos) << message;
}

RangeOptions withPrior(const std::vector<double>& prior) {
  RangeOptions o;
  o.anchor_prior = prior;
  return o;
}

TEST(Validate, DefaultsAreAllowed) {
  EXPECT_EQ(refusalOf(EstimatorConfig()), "");
  EXPECT_EQ(refusalOf(OdometryRangeConfig()), "");
}

TEST(Validate, AnchorPriors) {
  EXPECT_EQ(refusalOf(withPrior({})), "");
  EXPECT_EQ(refusalOf(withPrior({0, 1, 2, 3, 0.1})), "");
  EXPECT_EQ(refusalOf(withPrior({2147483647, 1, 2, 3, 1e-4, 4, -1, -2, -3, 1e6})), "");
  expectRefused(refusalOf(withPrior({1, 2, 3, 4})), "[Ranges] anchor_prior = 1 2 3 4: 4 numbers",
                "five for every anchor, id x y z sigma");
  expectRefused(refusalOf(withPrior({1, 2, 3, 4, 0.1, 2})), "[Ranges] anchor_prior = 1 2 3 4 0.1 2",
                "five for every anchor");
  expectRefused(refusalOf(withPrior({3, 1, 2, 3, 0})),
                "[Ranges] anchor_prior = 3 1 2 3 0: the sigma of anchor 3 is 0",
                "from 1e-04 to 1e+06 m");
  for (const double sigma : {-0.1, 1e-9, 1e7}) {
    expectRefused(refusalOf(withPrior({3, 1, 2, 3, sigma})), "[Ranges] anchor_prior = 3 1 2 3",
                  "from 1e-04 to 1e+06 m");
  }
  for (const double id : {-1.0, 0.5, 2147483648.0, 1e300}) {
    expectRefused(refusalOf(withPrior({id, 1, 2, 3, 0.1})),
                  "[Ranges] anchor_prior = ", "a whole number from 0 to 2147483647");
  }
  expectRefused(refusalOf(withPrior({1, 1, 2, 3, 0.1, 1, 4, 5, 6, 0.1})),
                "[Ranges] anchor_prior = 1 1 2 3 0.1 1 4 5 6 0.1: anchor 1 is there twice",
                "one prior for every anchor");
  expectRefused(refusalOf(withPrior({1, NAN, 2, 3, 0.1})), "[Ranges] anchor_prior = 1 nan",
                "numbers");
}

TEST(Validate, ABiasModelThatNobodyHasRead) {
  RangeOptions o;
  o.bias_model_file = "uwb.csv";
  expectRefused(refusalOf(o), "[Ranges] bias_model = uwb.csv: ", "or none");
}

/// A program's values get the bounds of a file's.
TEST(Validate, BoundsHoldForProgramsToo) {
  EstimatorConfig c;
  c.imu.acc_noise_density = 0;
  expectRefused(refusalOf(c.imu), "[Imu] acc_noise_density = 0: ", "a number from");
  expectRefused(refusalOf(c), "[Imu] acc_noise_density = 0: ", "a number from");
  c = {};
  c.window.loss = static_cast<window::ReprojectionLoss>(2);
  expectRefused(refusalOf(c), "[Window] loss = 2: ", "huber, cauchy");
  c = {};
  c.long_window.mode = static_cast<window::LongWindowMode>(3);
  expectRefused(refusalOf(c), "[Estimator] long_window = 3: ", "none, position, pose");
  c = {};
  c.long_window.gamma_r = std::numeric_limits<double>::quiet_NaN();
  expectRefused(refusalOf(c), "[LongWindow] gamma_r = ", "a number from");
  c = {};
  c.failure.max_blind_s = 0;
  expectRefused(refusalOf(c), "[Failure] max_blind_s = 0: ", "a number from");
  c = {};
  c.rest.min_tracks = 0;
  expectRefused(refusalOf(c), "[Rest] min_tracks = 0: ", "a whole number from");
  c = {};
  c.camera_time_offset_s = 11;
  expectRefused(refusalOf(c), "[Camera] time_offset_s = 11: ", "a number from");
  OdometryRangeConfig o;
  o.odometry.node_distance_m = -1;
  expectRefused(refusalOf(o), "[Odometry] node_distance_m = -1: ", "a number from");
  o = {};
  o.iterations = 0;
  EXPECT_NE(refusalOf(o).find("iterations is 0"), std::string::npos);
}

TEST(Validate, Patches) {
  vision::TrackerOptions o;
  o.patch_px = 16;
  expectRefused(refusalOf(o), "[Tracker] patch_px = 16: ", "an odd number");
}

TEST(Validate, FramesOfTheWindow) {
  window::WindowOptions o;
  o.keyframes = 6;
  o.newest_frames = 6;
  EXPECT_EQ(refusalOf(o), "");
  o.newest_frames = 7;
  expectRefused(refusalOf(o), "[Window] newest_frames = 7: ", "at most keyframes = 6");
}

TEST(Validate, Start) {
  StartupOptions o;
  o.min_span_s = o.max_span_s;
  expectRefused(refusalOf(o), "[Startup] max_span_s = 2: ", "above min_span_s = 2");
  o = {};
  o.max_scale_sigma = 0.1;
  expectRefused(refusalOf(o),
                "[Startup] max_scale_sigma = 0.1: ", "at most patient_scale_sigma = 0.05");
}

TEST(Validate, WhatOneSectionAsksOfAnother) {
  EstimatorConfig c;
  c.tracker.max_tracks = 20;
  expectRefused(refusalOf(c), "[Startup] min_shared_tracks = 25: ", "[Tracker] max_tracks = 20");
  c.startup.min_shared_tracks = 10;
  EXPECT_EQ(refusalOf(c), "");
  c.rest.min_tracks = 21;
  expectRefused(refusalOf(c), "[Rest] min_tracks = 21: ", "[Tracker] max_tracks = 20");
  c = {};
  c.startup.sigma_bias_gyro = 2;
  expectRefused(refusalOf(c), "[Startup] sigma_bias_gyro = 2: ", "[Failure] max_bias_gyro = 1");
  c = {};
  c.startup.sigma_bias_acc = 4;
  expectRefused(refusalOf(c), "[Startup] sigma_bias_acc = 4: ", "[Failure] max_bias_acc = 3");
  c = {};
  c.long_window.scale_walk_per_sqrt_m = 0.01;
  expectRefused(refusalOf(c), "[LongWindow] scale_walk_per_sqrt_m = 0.01: ", "scale_sigma above 0");
  c.long_window.scale_sigma = 0.1;
  EXPECT_EQ(refusalOf(c), "");
  c.long_window.mode = window::LongWindowMode::position;
  expectRefused(refusalOf(c), "[LongWindow] scale_sigma = 0.1: ", "0");
  // A device's scale may be held without naming how it would wander.
  OdometryRangeConfig o;
  o.long_window.scale_sigma = 0;
  EXPECT_EQ(refusalOf(o), "");
  o = {};
  o.long_window.mode = window::LongWindowMode::position;
  EXPECT_EQ(refusalOf(o), "");
}

TEST(Validate, NoEstimatorIsBuiltOnThem) {
  EstimatorConfig c;
  c.ranges.anchor_prior = {1, 2, 3, 4};
  EXPECT_THROW(VisualInertialEstimator{c}, std::invalid_argument);
  OdometryRangeConfig o;
  o.ranges.anchor_prior = {-1, 0, 0, 0, 0.1};
  EXPECT_THROW(OdometryRangeEstimator{o}, std::invalid_argument);
}

}  // namespace
}  // namespace vir::estimator
