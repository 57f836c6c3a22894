/// What comes out is in order; what cannot be put in order is counted by name.
#include "vir/rawlog/time_orderer.h"

#include <gtest/gtest.h>

#include "vir_test_rawlog.h"

namespace vir::rawlog {
namespace {

using test::imageAt;
using test::imuAt;
using test::kMs;
using test::kStart;
using test::rangeAt;

constexpr TimeNs kSecond = 1000 * kMs;

/// Pushes one by one and takes out what is ready each time, as a run does.
std::vector<TimeNs> run(TimeOrderer* orderer,
                        const std::vector<mrpt::obs::CObservation::Ptr>& input) {
  std::vector<TimeNs> out;
  const auto drain = [&] {
    while (const auto o = orderer->pop()) out.push_back(fromMrptTime(o->timestamp) - kStart);
  };
  for (const auto& o : input) {
    orderer->push(o);
    drain();
  }
  orderer->flush();
  drain();
  return out;
}

TEST(TimeOrderer, BurstsAreMerged) {
  std::vector<mrpt::obs::CObservation::Ptr> input;
  for (int burst = 0; burst < 5; ++burst) {
    for (int i = 0; i < 10; ++i) input.push_back(imuAt(kStart + (burst * 10 + i) * 50 * kMs));
    for (int i = 0; i < 5; ++i) input.push_back(imageAt(kStart + (burst * 5 + i) * 100 * kMs));
  }
  TimeOrderer orderer;
  const auto out = run(&orderer, input);
  EXPECT_EQ(out.size(), 75u);
  EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
  EXPECT_TRUE(orderer.counters().empty());
}

TEST(TimeOrderer, SwappedImagesAreSortedAndCounted) {
  std::vector<mrpt::obs::CObservation::Ptr> input;
  for (int i = 0; i < 20; ++i) input.push_back(imageAt(kStart + (i ^ 1) * 50 * kMs));
  TimeOrderer orderer;
  const auto out = run(&orderer, input);
  EXPECT_EQ(out.size(), 20u);
  EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
  EXPECT_TRUE(orderer.counters().empty());
  EXPECT_EQ(orderer.sorted(), (std::map<std::string, long>{{"CAM0", 10}}));
}

TEST(TimeOrderer, DelayIsBounded) {
  TimeOrderer orderer;
  orderer.push(imuAt(kStart));
  orderer.push(imuAt(kStart + 999 * kMs));
  EXPECT_EQ(orderer.pop(), nullptr);
  orderer.push(imuAt(kStart + 1000 * kMs));
  EXPECT_NE(orderer.pop(), nullptr);
  EXPECT_EQ(orderer.pop(), nullptr);
}

TEST(TimeOrderer, TooLateIsLeftOutAndCounted) {
  TimeOrderer orderer;
  std::vector<mrpt::obs::CObservation::Ptr> input;
  for (int i = 0; i < 40; ++i) input.push_back(imuAt(kStart + i * 100 * kMs));
  input.push_back(imuAt(kStart + 50 * kMs));
  input.push_back(imageAt(kStart + 51 * kMs));
  const auto out = run(&orderer, input);
  EXPECT_EQ(out.size(), 40u);
  EXPECT_EQ(orderer.counters(), (std::map<std::string, long>{{"late_CAM0", 1}, {"late_IMU0", 1}}));
}

TEST(TimeOrderer, RepeatedStamps) {
  TimeOrderer orderer;
  const auto out =
      run(&orderer, {imuAt(kStart), imuAt(kStart), imageAt(kStart), rangeAt(kStart, 1),
                     rangeAt(kStart, 2), imuAt(kStart + 2 * kSecond), imuAt(kStart + 2 * kSecond),
                     imageAt(kStart + 2 * kSecond), imageAt(kStart + 2 * kSecond)});
  EXPECT_EQ(out.size(), 6u);  // two anchors may share a stamp
  EXPECT_EQ(orderer.counters(),
            (std::map<std::string, long>{{"repeated_CAM0", 1}, {"repeated_IMU0", 2}}));
}

TEST(TimeOrderer, OneStampFarAheadDoesNotStopTheRest) {
  TimeOrderer orderer;
  std::vector<mrpt::obs::CObservation::Ptr> input;
  for (int i = 0; i < 100; ++i) {
    input.push_back(imuAt(kStart + i * 10 * kMs));
    if (i == 50) input.push_back(imageAt(kStart + 1'000'000 * kSecond));
  }
  const auto out = run(&orderer, input);
  EXPECT_EQ(out.size(), 100u);
  EXPECT_EQ(orderer.counters(), (std::map<std::string, long>{{"bad_stamp_CAM0", 1}}));
  EXPECT_TRUE(orderer.gaps().empty());
}

TEST(TimeOrderer, ARealGapIsKept) {
  TimeOrderer orderer;
  std::vector<mrpt::obs::CObservation::Ptr> input;
  for (int i = 0; i < 50; ++i) input.push_back(imuAt(kStart + i * 10 * kMs));
  for (int i = 0; i < 50; ++i) input.push_back(imuAt(kStart + 60 * kSecond + i * 10 * kMs));
  const auto out = run(&orderer, input);
  EXPECT_EQ(out.size(), 100u);
  EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
  EXPECT_TRUE(orderer.counters().empty());
  ASSERT_EQ(orderer.gaps().size(), 1u);
  EXPECT_EQ(orderer.gaps()[0], 60 * kSecond - 490 * kMs);
}

/// Every second stamp of a sensor is of another clock: the others go on as before.
TEST(TimeOrderer, WhatIsFarAheadNowAndThenIsNoGap) {
  for (const TimeNs ahead : {10 * kSecond, 1'000'000 * kSecond}) {
    TimeOrderer orderer;
    std::vector<mrpt::obs::CObservation::Ptr> input;
    for (int i = 0; i < 200; ++i) {
      input.push_back(imuAt(kStart + i * 10 * kMs + (i % 2 == 0 ? ahead : 0)));
    }
    input.erase(input.begin());  // which is what the others would be held against
    EXPECT_EQ(run(&orderer, input).size(), 100u);
    EXPECT_EQ(orderer.counters(), (std::map<std::string, long>{{"bad_stamp_IMU0", 99}}));
    EXPECT_TRUE(orderer.gaps().empty());
  }
}

/// A clock that was set only after the first readings: half a century is no gap of a recording.
TEST(TimeOrderer, AFewAtFirstThatAreFarBehind) {
  TimeOrderer orderer;
  std::vector<mrpt::obs::CObservation::Ptr> input{imageAt(0), imuAt(1000), imuAt(2000)};
  for (int i = 0; i < 100; ++i) input.push_back(imuAt(kStart + i * 10 * kMs));
  const auto out = run(&orderer, input);
  EXPECT_EQ(out.size(), 100u);
  EXPECT_EQ(out.front(), 0);
  EXPECT_EQ(orderer.counters(),
            (std::map<std::string, long>{{"bad_stamp_CAM0", 1}, {"bad_stamp_IMU0", 2}}));
  EXPECT_TRUE(orderer.gaps().empty());
}

TEST(TimeOrderer, SlowRecordingsComeOutWhole) {
  TimeOrderer orderer;
  std::vector<mrpt::obs::CObservation::Ptr> input;
  for (int i = 0; i < 25; ++i) input.push_back(rangeAt(kStart + i * 10 * kSecond, 1));
  EXPECT_EQ(run(&orderer, input).size(), 25u);
}

TEST(TimeOrderer, ClockSteppedBackIsCountedNotLostInSilence) {
  TimeOrderer orderer;
  std::vector<mrpt::obs::CObservation::Ptr> input;
  for (int i = 0; i < 300; ++i) input.push_back(imuAt(kStart + i * 10 * kMs));
  for (int i = 0; i < 30; ++i) input.push_back(imuAt(kStart + i * 10 * kMs + kMs));
  const auto out = run(&orderer, input);
  EXPECT_EQ(out.size(), 300u);
  EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
  EXPECT_EQ(orderer.counters().at("late_IMU0"), 30);
}

}  // namespace
}  // namespace vir::rawlog
