#include "vir/imu/spike_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace vir::imu {
namespace {

constexpr TimeNs kPeriod = 5'000'000;

/// 200 Hz, turning and shaking a little.
ImuSample reading(int k) {
  const double t = 0.005 * k;
  return {k * kPeriod, Vec3(0.5 * std::sin(3 * t), 0.3 * std::cos(5 * t), 0.2),
          Vec3(std::sin(20 * t), 2 * std::cos(31 * t), 9.81 + 0.5 * std::sin(57 * t))};
}

struct Fed {
  SpikeFilter filter;
  std::vector<ImuSample> taken;
  explicit Fed(const std::function<void(int, ImuSample*)>& spoil, int count = 400) {
    for (int k = 0; k < count; ++k) {
      ImuSample s = reading(k);
      spoil(k, &s);
      for (const ImuSample& a : filter.add(s)) taken.push_back(a);
    }
  }
};

TEST(SpikeFilter, LeavesGoodReadingsAsTheyAreAndWhereTheyAre) {
  const Fed fed([](int, ImuSample*) {});
  ASSERT_EQ(fed.taken.size(), 400u);
  for (int k = 0; k < 400; ++k) {
    const ImuSample& s = fed.taken[static_cast<std::size_t>(k)];
    ASSERT_EQ(s.t, reading(k).t);
    ASSERT_EQ(s.gyro, reading(k).gyro);
  }
  EXPECT_EQ(fed.filter.spikes() + fed.filter.impossible(), 0);
}

TEST(SpikeFilter, OneBadReadingIsLeftOutAndCounted) {
  for (const double rate : {5.0, -20.0, 200.0}) {
    const Fed fed([&](int k, ImuSample* s) { s->gyro.y() += k == 300 ? rate : 0; });
    EXPECT_EQ(fed.taken.size(), 399u) << rate;
    EXPECT_EQ(fed.filter.spikes(), 1) << rate;
    for (const ImuSample& s : fed.taken) EXPECT_NE(s.t, 300 * kPeriod) << rate;
  }
  for (const double acceleration : {50.0, -200.0, 3000.0}) {
    const Fed fed([&](int k, ImuSample* s) { s->acc.x() += k == 250 ? acceleration : 0; });
    EXPECT_EQ(fed.taken.size(), 399u) << acceleration;
    EXPECT_EQ(fed.filter.spikes(), 1) << acceleration;
  }
}

/// Before it is known what is usual: a start at rest takes the mean of the first readings for
/// level.
TEST(SpikeFilter, OneBadReadingAmongTheFirst) {
  for (const int at : {1, 2, 5, 50, 99}) {
    const Fed turned([&](int k, ImuSample* s) { s->gyro.x() += k == at ? 20 : 0; });
    EXPECT_EQ(turned.filter.spikes(), 1) << at;
    EXPECT_EQ(turned.taken.size(), 399u) << at;
    const Fed pushed([&](int k, ImuSample* s) { s->acc.x() += k == at ? 200 : 0; });
    EXPECT_EQ(pushed.filter.spikes(), 1) << at;
  }
}

TEST(SpikeFilter, TheVeryFirstReadingMayBeBad) {
  for (const double acceleration : {80.0, -200.0, 3000.0}) {
    const Fed fed([&](int k, ImuSample* s) { s->acc.z() += k == 0 ? acceleration : 0; });
    ASSERT_EQ(fed.taken.size(), 399u) << acceleration;
    EXPECT_EQ(fed.taken.front().t, kPeriod);
    EXPECT_EQ(fed.filter.spikes(), 1) << acceleration;
  }
  const Fed two([](int k, ImuSample* s) { s->gyro.x() += k == 0 ? 50 : k == 1 ? -50 : 0; });
  EXPECT_EQ(two.taken.size(), 398u);
  EXPECT_EQ(two.filter.spikes(), 2);
}

/// Switched on in a fast turn, or while it is thrown.
TEST(SpikeFilter, ABeginInFastMotionIsKeptWhole) {
  for (const int until : {400, 60}) {
    const Fed fed([until](int k, ImuSample* s) { s->gyro.z() += k < until ? 12 : 0; });
    EXPECT_EQ(fed.taken.size(), 400u) << until;
    EXPECT_EQ(fed.filter.spikes(), 0) << until;
  }
  const Fed wild([](int k, ImuSample* s) { s->gyro.z() += k < 8 ? (k % 2 == 0 ? 60 : -60) : 0; });
  EXPECT_EQ(wild.taken.size(), 400u) << "four that disagree are no spike";
  // A hole says nothing of what came before it.
  const Fed hole([](int k, ImuSample* s) {
    s->gyro.z() += k == 0 ? 12 : 0;
    s->t += k == 0 ? 0 : 1'000'000'000;
  });
  EXPECT_EQ(hole.taken.size(), 400u);
}

TEST(SpikeFilter, TwoThatDisagreeAreLeftOutToo) {
  const Fed fed([](int k, ImuSample* s) {
    if (k == 300) s->gyro.x() = 30;
    if (k == 301) s->gyro.x() = -30;
  });
  EXPECT_EQ(fed.taken.size(), 398u);
  EXPECT_EQ(fed.filter.spikes(), 2);
}

TEST(SpikeFilter, WhatNoImuCanReadIsLeftOutFromTheFirstReadingOn) {
  const Fed fed([](int k, ImuSample* s) {
    if (k == 0 || k == 200) s->acc.z() = 1e18;
    if (k == 1) s->gyro.z() = std::numeric_limits<double>::max();
  });
  EXPECT_EQ(fed.taken.size(), 397u);
  EXPECT_EQ(fed.filter.impossible(), 3);
}

/// A blow, or a turn that begins at once, is no spike: all readings stay, in order.
TEST(SpikeFilter, AStepIsKeptWhole) {
  const Fed fed([](int k, ImuSample* s) {
    if (k >= 300) s->acc.z() += 40;
    if (k >= 350) s->gyro.z() += 6;
  });
  ASSERT_EQ(fed.taken.size(), 400u);
  for (std::size_t k = 1; k < 400; ++k) ASSERT_GT(fed.taken[k].t, fed.taken[k - 1].t);
  EXPECT_EQ(fed.filter.spikes(), 0);
}

/// Motors: white noise of 15 m/s^2 and 0.5 rad/s in every reading.
TEST(SpikeFilter, VibrationIsKeptWhole) {
  unsigned state = 1;
  const auto noise = [&] {
    double sum = -6;
    for (int i = 0; i < 12; ++i) {
      state = state * 1664525u + 1013904223u;
      sum += static_cast<double>(state >> 8) / 16777216.0;
    }
    return sum;  // normal, sigma 1
  };
  const Fed fed(
      [&](int, ImuSample* s) {
        for (int i = 0; i < 3; ++i) {
          s->acc[i] += 15 * noise();
          s->gyro[i] += 0.5 * noise();
        }
      },
      4000);
  EXPECT_EQ(fed.filter.spikes(), 0);
  EXPECT_EQ(fed.taken.size(), 4000u);
}

TEST(SpikeFilter, WhatItsUserCountsGoesThrough) {
  const Fed fed([](int k, ImuSample* s) {
    if (k == 200) s->gyro.x() = std::nan("");
    if (k == 210) s->t = 150 * kPeriod;
  });
  EXPECT_EQ(fed.taken.size(), 400u);
  SpikeFilter filter;
  for (int k = 200; k < 400; ++k) filter.add(reading(k));
  filter.restart();
  EXPECT_EQ(filter.add(reading(0)).size(), 1u) << "a clock that was set back";
}

}  // namespace
}  // namespace vir::imu
