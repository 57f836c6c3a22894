/// Whatever comes in: no crash, no NaN, and it is counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>

#include "estimator_driver.h"
#include "vir/core/time_bounds.h"

namespace vir::estimator {
namespace {

using vir_test::EstimatorDriver;
using vir_test::kMs;

constexpr TimeNs kStart = 1400000000000000000;  // a Unix stamp

/// Every result is finite, in time order, and there is one per image that was taken.
std::vector<StateEstimate> expectSane(EstimatorDriver* d) {
  d->estimator.finish();
  std::vector<StateEstimate> out = d->estimator.take();
  for (std::size_t k = 0; k < out.size(); ++k) {
    EXPECT_TRUE(vir_test::finite(out[k])) << "image " << k << ": " << healthText(out[k]);
    EXPECT_TRUE(out[k].valid || !out[k].reason.empty()) << "image " << k;
  }
  for (const State& s : d->estimator.keyframes()) EXPECT_TRUE(s.T_W_B.p.allFinite());
  for (const Landmark& l : d->estimator.landmarks()) EXPECT_TRUE(l.p_W.allFinite());
  return out;
}

long count(const std::vector<StateEstimate>& all, bool valid) {
  return std::count_if(all.begin(), all.end(),
                       [&](const StateEstimate& e) { return e.valid == valid; });
}

TEST(EstimatorBadInput, StandingCleanRunIsTheYardstick) {
  EstimatorDriver d;
  d.run(kStart, kStart + 2000 * kMs);
  const auto out = expectSane(&d);
  ASSERT_EQ(out.size(), 40u);
  EXPECT_GT(count(out, true), 25);
  EXPECT_EQ(out.back().health, Health::standing);
  EXPECT_LT(out.back().state.T_W_B.p.norm(), 0.01);
  EXPECT_EQ(d.estimator.counters().images, 40);
  EXPECT_EQ(d.estimator.counters().images_unusable, 0);
  EXPECT_EQ(d.estimator.counters().images_out_of_order, 0);
  EXPECT_EQ(d.estimator.counters().images_without_imu, 0);
  EXPECT_EQ(d.estimator.counters().image_gaps, 0);
  EXPECT_EQ(d.estimator.resets(), 0);
  EXPECT_TRUE(d.estimator.warnings().empty());
}

TEST(EstimatorBadInput, ImagesBeforeAnyReading) {
  EstimatorDriver d;
  for (int k = 0; k < 5; ++k) d.estimator.addImage(kStart + k * 50 * kMs, d.image);
  d.run(kStart + 1000 * kMs, kStart + 3000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(out.size(), 45u);
  EXPECT_EQ(d.estimator.counters().images_without_imu, 5);
  EXPECT_TRUE(out.back().valid);
}

TEST(EstimatorBadInput, ImagesOnlyNeverAnyReading) {
  EstimatorDriver d;
  for (int k = 0; k < 150; ++k) d.estimator.addImage(kStart + k * 50 * kMs, d.image);
  const auto out = expectSane(&d);
  EXPECT_EQ(out.size(), 150u);
  EXPECT_EQ(d.estimator.counters().images_without_imu, 150);
  EXPECT_EQ(count(out, true), 0);
}

TEST(EstimatorBadInput, NothingAtAll) {
  EstimatorDriver d;
  EXPECT_TRUE(expectSane(&d).empty());
  EXPECT_TRUE(d.estimator.keyframes().empty());
  VisualInertialEstimator bare{EstimatorConfig()};
  EXPECT_FALSE(bare.hasCamera());
  bare.finish();
  EXPECT_TRUE(bare.keyframes().empty());
}

TEST(EstimatorBadInput, StampsThatNoClockShows) {
  EstimatorDriver d;
  d.run(kStart, kStart + 1000 * kMs);
  for (const TimeNs t : {TimeNs(-1), INT64_MIN, INT64_MAX, kLatestStamp}) {
    d.estimator.addImage(t, d.image);
    d.estimator.addImu({t, Vec3::Zero(), Vec3(0, 0, 9.81)});
    Range range;
    range.t = t;
    range.range_m = 3;
    d.estimator.addRange(range);
  }
  d.run(kStart + 1000 * kMs, kStart + 2000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(d.estimator.counters().bad_stamps, 12);
  EXPECT_EQ(out.size(), 40u);
  EXPECT_EQ(d.estimator.resets(), 0);
  EXPECT_EQ(d.estimator.counters().images, 40);
}

TEST(EstimatorBadInput, RepeatedAndReversedImageStamps) {
  EstimatorDriver d;
  d.run(kStart, kStart + 1000 * kMs);
  d.estimator.addImage(kStart + 1000 * kMs, d.image);  // repeated
  d.estimator.addImage(kStart + 500 * kMs, d.image);   // from the past
  d.run(kStart + 1000 * kMs, kStart + 2000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(d.estimator.counters().images_out_of_order, 2);
  EXPECT_EQ(d.estimator.counters().images, 42);
  ASSERT_EQ(out.size(), 40u);
  for (std::size_t k = 1; k < out.size(); ++k) EXPECT_LT(out[k - 1].state.t, out[k].state.t);
  EXPECT_TRUE(out.back().valid);
  EXPECT_EQ(d.estimator.resets(), 0);
}

TEST(EstimatorBadInput, EmptyWrongSizedAndBlankImages) {
  EstimatorDriver d;
  d.run(kStart, kStart + 1000 * kMs);
  const std::vector<cv::Mat> bad = {
      cv::Mat(), cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)),
      cv::Mat(vir_test::kHeight, vir_test::kWidth, CV_8UC3, cv::Scalar(0)),
      cv::Mat(vir_test::kHeight, vir_test::kWidth, CV_16UC1, cv::Scalar(0))};
  TimeNs t = kStart + 1000 * kMs;
  for (const cv::Mat& image : bad) {
    d.imu(t, t + 50 * kMs);
    t += 50 * kMs;
    d.estimator.addImage(t, image);
  }
  EXPECT_EQ(d.estimator.counters().images_unusable, 4);
  // Darkness counts too: there is nothing to see.
  const cv::Mat dark(vir_test::kHeight, vir_test::kWidth, CV_8UC1, cv::Scalar(0));
  d.imu(t, t + 50 * kMs);
  d.estimator.addImage(t + 50 * kMs, dark);
  EXPECT_EQ(d.estimator.counters().images_unusable, 5);
  d.run(t + 50 * kMs, t + 1050 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(out.size(), 45u);
  EXPECT_TRUE(out.back().valid);
  EXPECT_EQ(d.estimator.resets(), 0);
}

TEST(EstimatorBadInput, ReadingsThatAreNotFinite) {
  EstimatorDriver d;
  d.run(kStart, kStart + 1000 * kMs);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  d.estimator.addImu({kStart + 1001 * kMs, Vec3(nan, 0, 0), Vec3(0, 0, 9.81)});
  d.estimator.addImu({kStart + 1002 * kMs, Vec3(0, 0, 0), Vec3(0, inf, 9.81)});
  d.run(kStart + 1000 * kMs, kStart + 2000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(d.estimator.imuCounters().not_finite, 2);
  EXPECT_EQ(out.size(), 40u);
  EXPECT_TRUE(out.back().valid);
}

TEST(EstimatorBadInput, SingleReadingsThatCannotBe) {
  EstimatorDriver d;
  d.run(kStart, kStart + 1000 * kMs);
  d.estimator.addImu({kStart + 1002 * kMs, Vec3(20, 0, 0), Vec3(0, 200, 9.81)});
  d.run(kStart + 1000 * kMs, kStart + 2000 * kMs);
  d.estimator.addImu({kStart + 2002 * kMs, Vec3::Zero(), Vec3(0, 0, 1e18)});
  d.run(kStart + 2000 * kMs, kStart + 3000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(d.estimator.counters().imu_spikes, 1);
  EXPECT_EQ(d.estimator.counters().imu_impossible, 1);
  EXPECT_EQ(d.estimator.imuCounters().accepted, 600);
  EXPECT_EQ(out.size(), 60u);
  EXPECT_EQ(d.estimator.resets(), 0);
  EXPECT_TRUE(out.back().valid);
  EXPECT_LT(out.back().state.T_W_B.p.norm(), 0.01);
}

TEST(EstimatorBadInput, RepeatedAndLateReadings) {
  EstimatorDriver d;
  d.run(kStart, kStart + 1000 * kMs);
  for (int k = 0; k < 20; ++k) d.imuAt(kStart + 900 * kMs);
  d.run(kStart + 1000 * kMs, kStart + 2000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(d.estimator.imuCounters().out_of_order, 20);
  EXPECT_EQ(d.estimator.counters().clock_steps, 0);
  EXPECT_EQ(d.estimator.resets(), 0);
  EXPECT_TRUE(out.back().valid);
}

TEST(EstimatorBadInput, ClockOfTheImuSetBack) {
  EstimatorDriver d;
  d.run(kStart, kStart + 2000 * kMs);
  const TimeNs back = kStart - 10000 * kMs;
  d.run(back, back + 3000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(d.estimator.counters().clock_steps, 1);
  EXPECT_EQ(d.estimator.resets(), 1);
  ASSERT_FALSE(d.estimator.warnings().empty());
  EXPECT_TRUE(out.back().valid) << healthText(out.back());
  EXPECT_EQ(out.back().segment, 1);
  EXPECT_LT(out.back().state.T_W_B.p.norm(), 0.02) << "carries on from where it was";
}

TEST(EstimatorBadInput, AHoleIsForgottenWhenTheClockIsSetBack) {
  EstimatorDriver d;
  d.run(kStart, kStart + 2000 * kMs);
  d.run(kStart + 7000 * kMs, kStart + 9000 * kMs);
  ASSERT_EQ(d.estimator.counters().images_without_imu, 0);
  ASSERT_EQ(d.estimator.counters().imu_gaps, 1 + 1) << "the hole, and the link across it";
  // Back into the hole, where readings are complete now.
  d.run(kStart + 2100 * kMs, kStart + 3900 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(d.estimator.counters().clock_steps, 1);
  EXPECT_EQ(d.estimator.counters().images_without_imu, 0);
  EXPECT_TRUE(out.back().valid) << healthText(out.back());
}

TEST(EstimatorBadInput, AHoleAfterAStepOfTheClockIsToldAgain) {
  EstimatorDriver d;
  d.run(kStart, kStart + 2000 * kMs);
  d.imu(kStart + 2600 * kMs, kStart + 2700 * kMs);
  d.estimator.addImage(kStart + 2650 * kMs, d.image);  // its link has a gap
  const auto told = [&d] {
    long n = 0;
    for (const std::string& w : d.estimator.warnings()) {
      n += w.find("IMU readings missing") != std::string::npos;
    }
    return n;
  };
  ASSERT_EQ(told(), 1);
  const TimeNs back = kStart - 10000 * kMs;
  d.run(back, back + 2000 * kMs);
  ASSERT_EQ(d.estimator.counters().clock_steps, 1);
  d.run(back + 2600 * kMs, back + 4000 * kMs);
  EXPECT_EQ(told(), 2);
  expectSane(&d);
}

TEST(EstimatorBadInput, SeveralHolesAtOnce) {
  EstimatorDriver d;
  d.run(kStart, kStart + 2000 * kMs);
  // Images that come late find two holes behind them, too long to be bridged.
  d.imu(kStart + 7050 * kMs, kStart + 7500 * kMs);
  d.imu(kStart + 12250 * kMs, kStart + 14000 * kMs);
  for (TimeNs t = kStart + 2050 * kMs; t <= kStart + 14000 * kMs; t += 50 * kMs) {
    d.estimator.addImage(t, d.image);
  }
  const auto out = expectSane(&d);
  EXPECT_EQ(out.size(), 280u);
  EXPECT_EQ(d.estimator.counters().images_without_imu, 101 + 95);
  EXPECT_TRUE(out.back().valid) << healthText(out.back());
}

TEST(EstimatorBadInput, AnchorsPutDownBeforeThereIsAPose) {
  EstimatorDriver d;
  d.estimator.anchorDeployed(3, Vec3(0.1, 0, 0), 0.1);
  d.run(kStart, kStart + 2000 * kMs);
  d.estimator.anchorDeployed(4, Vec3(0.1, 0, 0), 0.1);
  d.estimator.anchorDeployed(5, Vec3(0.1, 0, 0), 0);
  d.run(kStart + 2000 * kMs, kStart + 2200 * kMs);
  expectSane(&d);
  std::map<std::string, long> counts;
  for (const auto& [name, n] : d.estimator.rangeCounters()) counts[name] = n;
  EXPECT_EQ(counts["anchors_put_down_without_a_pose"], 1);
  EXPECT_EQ(counts["anchors_put_down_unusable"], 1);
  const std::vector<std::string>& warnings = d.estimator.warnings();
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("anchor 3 was put down"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[1].find("anchor 5 was put down"), std::string::npos) << warnings[1];
}

TEST(EstimatorBadInput, TwoSecondsWithoutReadings) {
  EstimatorDriver d;
  d.run(kStart, kStart + 2000 * kMs);
  for (int k = 1; k <= 40; ++k) d.estimator.addImage(kStart + (2000 + 50 * k) * kMs, d.image);
  EXPECT_EQ(d.estimator.take().size(), 40u) << "the images wait for readings";
  d.run(kStart + 4000 * kMs, kStart + 6000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(out.size(), 80u) << "and none of them gets lost";
  EXPECT_EQ(d.estimator.imuCounters().gaps, 1);
  EXPECT_GT(d.estimator.counters().imu_gaps, 0);
  EXPECT_FALSE(d.estimator.warnings().empty());
  EXPECT_TRUE(out.back().valid);
  EXPECT_LT(out.back().state.T_W_B.p.norm(), 0.2);
}

TEST(EstimatorBadInput, TwoSecondsWithoutImages) {
  EstimatorDriver d;
  d.run(kStart, kStart + 2000 * kMs);
  d.imu(kStart + 2000 * kMs, kStart + 4000 * kMs);
  d.run(kStart + 4000 * kMs, kStart + 6000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_EQ(out.size(), 80u);
  EXPECT_EQ(d.estimator.counters().image_gaps, 1);
  EXPECT_EQ(d.estimator.warnings().size(), 1u);
  EXPECT_TRUE(out.back().valid);
  EXPECT_LT(out.back().state.T_W_B.p.norm(), 0.2);
}

TEST(EstimatorBadInput, DarknessForLongerThanItMayLastStartsASegment) {
  EstimatorConfig config;
  config.failure.max_blind_s = 1.0;
  EstimatorDriver d(1, config);
  d.run(kStart, kStart + 2000 * kMs);
  const cv::Mat lit = d.image;
  d.image = cv::Mat(vir_test::kHeight, vir_test::kWidth, CV_8UC1, cv::Scalar(0));
  d.run(kStart + 2000 * kMs, kStart + 4000 * kMs);
  d.image = lit;
  d.run(kStart + 4000 * kMs, kStart + 6000 * kMs);
  const auto out = expectSane(&d);
  EXPECT_GE(d.estimator.resets(), 1);
  EXPECT_EQ(out.back().segment, d.estimator.resets());
  EXPECT_TRUE(out.back().valid);
  EXPECT_FALSE(d.estimator.warnings().empty());
}

TEST(EstimatorBadInput, EveryImageAnotherScene) {
  EstimatorDriver d;
  for (unsigned k = 1; k <= 40; ++k) {
    d.imu(kStart + (k - 1) * 50 * kMs, kStart + k * 50 * kMs);
    d.estimator.addImage(kStart + k * 50 * kMs, vir_test::texture(100 + k));
  }
  const auto out = expectSane(&d);
  EXPECT_EQ(out.size(), 40u);
  EXPECT_EQ(count(out, true), 0) << "nothing to start from";
  EXPECT_FALSE(d.estimator.longestWaitReason().empty());
}

}  // namespace
}  // namespace vir::estimator
