/// An IMU with a clock of its own that wraps, jumps, drifts or stands still, and a host that
/// sleeps: the driver as a plugin, in simulated time.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationIMU.h>

#include <cmath>
#include <functional>

#include "messages.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/live_source.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_host_time.h"
#include "vir_test_paths.h"
#include "vir_test_pty.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

constexpr TimeNs kMs = 1'000'000, kS = 1000 * kMs;
constexpr TimeNs kBegin = 1'700'000'000 * kS, kPeriod = 5 * kMs;
constexpr TimeNs kWrap = (TimeNs{1} << 32) * 1000;  // 32 bits of microseconds

struct Stamped {
  TimeNs truth = 0;  ///< host time at which it was measured
  TimeNs stamp = 0;
};

struct Played {
  std::vector<Stamped> readings;
  long restarts = 0, glitches = 0;
};

/// `n` readings, 5 ms apart, that arrive when they are measured. `device`: its clock, by the time
/// since the begin; `host`: the host's, the same.
Played play(int n, const std::function<TimeNs(TimeNs)>& device,
            const std::function<TimeNs(TimeNs)>& host, const std::string& protocol) {
  roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_serial_imu.so");
  const test::TempFolder folder;
  test::Pty pty(folder / "tty");
  test::HostTime time;
  time.is(kBegin);
  const auto sensor = roles::createSensor("SerialImu");
  sensor->loadConfig(
      mrpt::config::CConfigFileMemory("[imu]\ndriver = SerialImu\nprocess_rate = 100\nport = " +
                                      pty.path() + "\nprotocol = " + protocol + "\n"),
      "imu");
  sensor->initialize();
  Played out;
  for (int i = 0; i < n; ++i) {
    const TimeNs t = i * kPeriod;
    emulator::ImuMessage m;
    m.device_time = device(t);
    m.sequence = static_cast<unsigned>(i);
    time.is(kBegin + host(t));
    pty.send(emulator::imuEncoder(protocol)(m));
    std::size_t before = out.readings.size();
    for (int k = 0; k < 50 && out.readings.size() == before; ++k) {
      sensor->doProcess();
      for (const auto& [stamp, object] : sensor->getObservations()) {
        out.readings.push_back({kBegin + host(t), rawlog::fromMrptTime(stamp)});
      }
    }
  }
  for (const auto& [name, count] : dynamic_cast<roles::LiveSource&>(*sensor).counters()) {
    if (name == "clock_restarts") out.restarts = count;
    if (name == "clock_glitches") out.glitches = count;
  }
  return out;
}

TimeNs goesOn(TimeNs t) { return t; }

/// All are there, each later than the one before and none before it was measured.
void expectInOrder(const Played& played, int n) {
  ASSERT_EQ(played.readings.size(), static_cast<std::size_t>(n));
  TimeNs last = 0;
  for (const Stamped& r : played.readings) {
    EXPECT_GT(r.stamp, last);
    last = r.stamp;
  }
}

/// Largest distance from the truth of readings [from, to) [ms].
double worstMs(const Played& played, std::size_t from, std::size_t to) {
  double worst = 0;
  for (std::size_t i = from; i < to; ++i) {
    const Stamped& r = played.readings[i];
    worst = std::max(worst, std::abs(1e3 * toSeconds(r.stamp - r.truth)));
  }
  return worst;
}

TEST(ImuClock, WrapsAfter32BitsOfMicroseconds) {
  for (const std::string protocol : {"binary", "text"}) {
    const int n = 1200;
    const Played played = play(
        n, [](TimeNs t) { return (kWrap - 3 * kS + t) % kWrap; }, goesOn, protocol);
    expectInOrder(played, n);
    EXPECT_EQ(played.restarts, 0) << protocol;
    EXPECT_EQ(played.glitches, 0) << protocol;
    // From the last reading before the wrap on: arrival by arrival the line stays where it was.
    EXPECT_LT(worstMs(played, 590, 1200), 1) << protocol;
  }
}

TEST(ImuClock, Drifts) {
  for (const double ppm : {200.0, -200.0}) {
    const int n = 200 * 40;
    const auto drifting = [ppm](TimeNs t) {
      return 5 * kS + t + static_cast<TimeNs>(static_cast<double>(t) * ppm * 1e-6);
    };
    const Played played = play(n, drifting, goesOn, "binary");
    expectInOrder(played, n);
    EXPECT_EQ(played.restarts, 0) << ppm;
    EXPECT_EQ(played.glitches, 0) << ppm;
    // 40 s make 8 ms of it.
    EXPECT_LT(worstMs(played, 200 * 20, 200 * 40), 1) << ppm;
  }
}

TEST(ImuClock, JumpsAndStartsAgain) {
  const auto ahead = [](TimeNs t) { return t < 2 * kS ? t : t + 600 * kS; };
  const auto anew = [](TimeNs t) { return t < 2 * kS ? 900 * kS + t : t - 2 * kS; };
  for (const auto& device : {std::function<TimeNs(TimeNs)>(ahead), {anew}}) {
    const Played played = play(800, device, goesOn, "binary");
    expectInOrder(played, 800);
    EXPECT_EQ(played.restarts, 1);
    EXPECT_LT(worstMs(played, 300, 400), 1);
    EXPECT_LT(worstMs(played, 500, 800), 1);
  }
}

/// The host slept for 20 s; the device did too, or went on.
TEST(ImuClock, GoesOnAfterTheHostHasSlept) {
  const auto slept = [](TimeNs t) { return t < 2 * kS ? t : t + 20 * kS; };
  for (const bool device_too : {true, false}) {
    const Played played = play(
        800, [&](TimeNs t) { return device_too ? t : slept(t); }, slept, "binary");
    expectInOrder(played, 800);
    EXPECT_EQ(played.restarts, device_too ? 1 : 0);
    EXPECT_LT(worstMs(played, 300, 400), 1);
    EXPECT_LT(worstMs(played, 500, 800), 1);
    EXPECT_GT(played.readings[400].stamp - played.readings[399].stamp, 19 * kS);
  }
}

}  // namespace
}  // namespace vir
