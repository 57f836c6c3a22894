/// Simulated devices: offset, drift, wrap-around, delays that only ever lengthen.
#include "vir/core/device_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "vir/core/random.h"

namespace {

using vir::DeviceClock;
using vir::DeviceClockOptions;
using vir::Random;
using vir::TimeNs;
using vir::toSeconds;

constexpr TimeNs kMs = 1'000'000, kS = 1'000'000'000;
constexpr TimeNs kEpoch = 1'700'000'000 * kS;
constexpr TimeNs kLeastDelay = 400'000;  // cannot be seen, so it belongs to the result

struct Device {
  TimeNs period = 5 * kMs;
  double drift_ppm = 50;    ///< of the host's clock against the device's
  TimeNs start = 123 * kS;  ///< device time at the host's kEpoch
  TimeNs wrap = 0;
  double mean_delay_s = 0.002;
  /// Extra delay of what is measured at a time since kEpoch.
  std::function<TimeNs(TimeNs)> extra = [](TimeNs) { return TimeNs{0}; };
  /// What the host has slept in all when what is measured at a time since kEpoch arrives.
  std::function<TimeNs(TimeNs)> slept = nullptr;
  /// Device time at a time since its start; for restarts.
  std::function<TimeNs(TimeNs)> device = nullptr;
};

struct Sample {
  TimeNs truth = 0;  ///< host time of the measurement plus the least delay
  TimeNs result = 0, arrival = 0;
};

/// `n` samples through the clock; checks what must hold for each.
std::vector<Sample> run(const Device& d, DeviceClock* clock, int n) {
  Random random(99);
  std::vector<Sample> samples;
  TimeNs last_arrival = 0;
  for (int i = 0; i < n; ++i) {
    const TimeNs on_device = i * d.period;
    const TimeNs on_host =
        on_device + static_cast<TimeNs>(static_cast<double>(on_device) * d.drift_ppm * 1e-6);
    TimeNs raw = d.device ? d.device(on_device) : d.start + on_device;
    if (d.wrap > 0) raw %= d.wrap;
    Sample s;
    s.truth = kEpoch + on_host + kLeastDelay;
    const double delay_s = -d.mean_delay_s * std::log(1 - random.uniform());
    s.arrival = s.truth + vir::fromSeconds(delay_s) + d.extra(on_host);
    // Bytes of a wire keep their order.
    s.arrival = last_arrival = std::max(last_arrival, s.arrival);
    if (d.slept) clock->hostSlept(d.slept(on_host));
    s.result = clock->stamp(raw, s.arrival);
    const TimeNs last = samples.empty() ? 0 : samples.back().result;
    EXPECT_GT(s.result, last) << "sample " << i;
    if (s.result > last + 100) {
      EXPECT_LE(s.result, s.arrival) << "sample " << i;
    }
    samples.push_back(s);
  }
  return samples;
}

double worstMs(const std::vector<Sample>& samples, std::size_t from, std::size_t to) {
  double worst = 0;
  for (std::size_t i = from; i < to; ++i) {
    worst = std::max(worst, std::abs(static_cast<double>(samples[i].result - samples[i].truth)));
  }
  return worst * 1e-6;
}

TEST(DeviceClock, JitterAndDriftOfAnImu) {
  for (const double ppm : {50.0, -50.0, 0.0, 200.0}) {
    Device d;
    d.drift_ppm = ppm;
    DeviceClock clock;
    const auto samples = run(d, &clock, 200 * 120);  // 2 min at 200 Hz
    EXPECT_NEAR(clock.driftPpm(), ppm, 3) << ppm;
    EXPECT_TRUE(clock.driftKnown());
    EXPECT_LT(worstMs(samples, 200 * 20, samples.size()), 0.15) << ppm;
    // While the drift is not known it adds up, for 10 s.
    EXPECT_LT(worstMs(samples, 200, 200 * 20), 0.2 + std::abs(ppm) * 0.01) << ppm;
    EXPECT_EQ(clock.restarts(), 0);
    EXPECT_EQ(clock.glitches(), 0);
  }
}

/// Arrival times of the same data are far worse: what the class is for.
TEST(DeviceClock, ArrivalTimesAreWorse) {
  DeviceClock clock;
  const auto samples = run(Device(), &clock, 200 * 30);
  double sum = 0;
  for (const Sample& s : samples) sum += static_cast<double>(s.arrival - s.truth) * 1e-6;
  EXPECT_GT(sum / static_cast<double>(samples.size()), 1.8);
}

TEST(DeviceClock, SlowRadioWithJitter) {
  Device d;
  d.period = 100 * kMs;
  d.mean_delay_s = 0.005;
  DeviceClock clock;
  const auto samples = run(d, &clock, 10 * 300);
  EXPECT_LT(worstMs(samples, 10 * 60, samples.size()), 1.2);
}

TEST(DeviceClock, WrapAround) {
  Device d;
  d.wrap = (TimeNs{1} << 32) * 1000;  // 32 bits of microseconds
  d.start = d.wrap - 30 * kS;
  DeviceClockOptions o;
  o.wrap = d.wrap;
  DeviceClock clock(o);
  const auto samples = run(d, &clock, 200 * 60);
  EXPECT_EQ(clock.restarts(), 0);
  EXPECT_EQ(clock.glitches(), 0);
  EXPECT_LT(worstMs(samples, 200 * 20, samples.size()), 0.15);
}

TEST(DeviceClock, LateBursts) {
  Device d;
  // Now and then the host sleeps: everything of two seconds comes at the end of them.
  d.extra = [](TimeNs t) {
    const TimeNs phase = t % (15 * kS);
    return phase > 12 * kS && phase < 14 * kS ? 14 * kS - phase : TimeNs{0};
  };
  DeviceClock clock;
  const auto samples = run(d, &clock, 200 * 120);
  EXPECT_EQ(clock.restarts(), 0);
  EXPECT_LT(worstMs(samples, 200 * 26, samples.size()), 0.3);
}

TEST(DeviceClock, RestartIsNoticed) {
  for (const TimeNs up_before : {20 * kS, 3000 * kS}) {
    Device d;
    d.start = up_before;
    d.device = [=](TimeNs t) { return t < 40 * kS ? up_before + t : t - 40 * kS + 2 * kS; };
    DeviceClock clock;
    const auto samples = run(d, &clock, 200 * 80);
    EXPECT_EQ(clock.restarts(), 1);
    EXPECT_LT(worstMs(samples, 200 * 20, 200 * 40), 0.15);
    // At once no worse than arrival times, and soon as good as before.
    EXPECT_LT(worstMs(samples, 200 * 40, 200 * 45), 25);
    EXPECT_LT(worstMs(samples, 200 * 60, samples.size()), 0.2);
  }
}

TEST(DeviceClock, JumpForwardIsARestartToo) {
  Device d;
  d.device = [](TimeNs t) { return t < 40 * kS ? t : t + 600 * kS; };
  DeviceClock clock;
  const auto samples = run(d, &clock, 200 * 80);
  EXPECT_EQ(clock.restarts(), 1);
  EXPECT_LT(worstMs(samples, 200 * 60, samples.size()), 0.2);
}

TEST(DeviceClock, HostClockSetForward) {
  Device d;
  d.extra = [](TimeNs t) { return t > 30 * kS ? 700 * kMs : 0; };  // seen as a delay for ever
  DeviceClock clock;
  const auto samples = run(d, &clock, 200 * 80);
  EXPECT_EQ(clock.restarts(), 1);
  for (std::size_t i = 200 * 60; i < samples.size(); ++i) {
    EXPECT_LT(std::abs(samples[i].result - samples[i].truth - 700 * kMs), kMs / 4);
  }
}

/// Too short to be told by the arrivals alone: 3 s of delay may be a burst.
TEST(DeviceClock, ADeviceThatSleptWithTheHostIsFollowedAtOnce) {
  for (const TimeNs slept : {300 * kMs, 3 * kS, 4900 * kMs, 20 * kS}) {
    Device d;
    d.extra = [slept](TimeNs t) { return t > 30 * kS ? slept : 0; };
    d.slept = [slept](TimeNs t) { return (t > 30 * kS ? slept : 0) - 1000; };  // no sleep yet
    DeviceClock clock;
    const auto samples = run(d, &clock, 200 * 60);
    EXPECT_EQ(clock.restarts(), 1) << slept;
    double worst = 0;
    for (std::size_t i = 200 * 30 + 2; i < samples.size(); ++i) {
      worst = std::max(worst, std::abs(toSeconds(samples[i].result - samples[i].truth - slept)));
    }
    EXPECT_LT(worst, 0.025) << slept << ": no worse than arrival times";
  }
}

TEST(DeviceClock, ADeviceThatWentOnWhileTheHostSleptIsToo) {
  for (const TimeNs slept : {300 * kMs, 3 * kS, 4900 * kMs}) {
    Device d;
    // What it measured meanwhile was lost but for the last, which waited.
    d.device = [slept](TimeNs t) { return 123 * kS + (t < 30 * kS ? t : t + slept); };
    const auto waited = [](TimeNs t) { return t > 30 * kS - 50 * kMs && t <= 30 * kS; };
    d.extra = [=](TimeNs t) { return waited(t) ? 30 * kS - t + slept : t > 30 * kS ? slept : 0; };
    d.slept = [=](TimeNs t) { return 7 * kS + (waited(t) || t > 30 * kS ? slept : 0); };
    d.drift_ppm = 0;
    DeviceClock clock;
    const auto samples = run(d, &clock, 200 * 60);
    EXPECT_EQ(clock.restarts(), 0) << slept;
    for (std::size_t i = 200 * 30 + 4; i < samples.size(); ++i) {
      ASSERT_NEAR(toSeconds(samples[i].result - samples[i].truth - slept), 0, 0.001) << i;
    }
  }
}

TEST(DeviceClock, SingleWildStampsChangeNothing) {
  Device d;
  int i = 0;
  Random random(5);
  d.device = [&](TimeNs t) {
    return ++i % 50 == 0 ? static_cast<TimeNs>(random.uniform() * 4e18) : 123 * kS + t;
  };
  DeviceClock clock;
  const auto samples = run(d, &clock, 200 * 60);
  EXPECT_EQ(clock.restarts(), 0);
  EXPECT_GT(clock.glitches(), 200);
  int off = 0;
  for (std::size_t k = 200 * 20; k < samples.size(); ++k) {
    off += std::abs(samples[k].result - samples[k].truth) > kMs / 4;
  }
  EXPECT_LT(off, 200 * 40 / 10);  // the wild ones and, where they arrived late, a few after
}

TEST(DeviceClock, RepeatedStampsStillGrow) {
  DeviceClock clock;
  TimeNs last = 0;
  for (int i = 0; i < 100; ++i) {
    const TimeNs t = clock.stamp((i / 4) * 10 * kMs, kEpoch + (i / 4) * 10 * kMs);
    EXPECT_GE(t, last + 100);
    last = t;
  }
}

}  // namespace
