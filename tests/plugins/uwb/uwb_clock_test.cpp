/// A radio with a clock of its own that wraps, jumps and drifts: the driver as a plugin, in
/// simulated time.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

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
constexpr TimeNs kBegin = 1'700'000'000 * kS, kPeriod = 50 * kMs;

struct Played {
  std::vector<double> errors_ms;  ///< stamp less the host time of the measurement
  long restarts = 0, glitches = 0;
};

/// `n` messages, 50 ms apart, that arrive when they are measured. `device`: its clock, by the time
/// since the begin.
Played play(const std::string& protocol, int n, const std::function<TimeNs(TimeNs)>& device) {
  roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_uwb.so");
  const test::TempFolder folder;
  test::Pty pty(folder / "tty");
  test::HostTime time;
  time.is(kBegin);
  const auto sensor = roles::createSensor("UwbSerial");
  sensor->loadConfig(mrpt::config::CConfigFileMemory(
                         "[uwb]\ndriver = UwbSerial\nprocess_rate = 100\nport = " + pty.path() +
                         "\nprotocol = " + protocol + "\nstamp = device\n"),
                     "uwb");
  sensor->initialize();
  Played out;
  TimeNs last = 0;
  for (int i = 0; i < n; ++i) {
    const TimeNs t = i * kPeriod;
    emulator::RangeMessage m;
    m.device_time = device(t);
    m.sequence = static_cast<unsigned>(i);
    m.items = {{1, 3.5}};
    time.is(kBegin + t);
    pty.send(emulator::rangeEncoder(protocol)(m));
    const std::size_t before = out.errors_ms.size();
    for (int k = 0; k < 50 && out.errors_ms.size() == before; ++k) {
      sensor->doProcess();
      for (const auto& [mrpt_stamp, object] : sensor->getObservations()) {
        const TimeNs stamp = rawlog::fromMrptTime(mrpt_stamp);
        EXPECT_GT(stamp, last) << i;
        last = stamp;
        out.errors_ms.push_back(1e3 * toSeconds(stamp - (kBegin + t)));
      }
    }
  }
  EXPECT_EQ(out.errors_ms.size(), static_cast<std::size_t>(n));
  for (const auto& [name, count] : dynamic_cast<roles::LiveSource&>(*sensor).counters()) {
    if (name == "clock_restarts") out.restarts = count;
    if (name == "clock_glitches") out.glitches = count;
  }
  return out;
}

double worst(const std::vector<double>& errors, std::size_t from, std::size_t to) {
  double out = 0;
  for (std::size_t i = from; i < to; ++i) out = std::max(out, std::abs(errors.at(i)));
  return out;
}

/// Its stamps are whole milliseconds.
TEST(UwbClock, WrapsAfter32BitsOfMilliseconds) {
  constexpr TimeNs wrap = (TimeNs{1} << 32) * kMs;
  for (const std::string protocol : {"nlink", "trek1000"}) {
    const Played played = play(protocol, 200, [](TimeNs t) { return (wrap - 5 * kS + t) % wrap; });
    EXPECT_EQ(played.restarts, 0) << protocol;
    EXPECT_EQ(played.glitches, 0) << protocol;
    EXPECT_LT(worst(played.errors_ms, 95, 200), 2) << protocol;
  }
}

TEST(UwbClock, Drifts) {
  for (const double ppm : {200.0, -200.0}) {
    const Played played = play("json", 20 * 60, [ppm](TimeNs t) {
      return kS + t + static_cast<TimeNs>(static_cast<double>(t) * ppm * 1e-6);
    });
    EXPECT_EQ(played.restarts, 0) << ppm;
    EXPECT_EQ(played.glitches, 0) << ppm;
    // A minute makes 12 ms of it.
    EXPECT_LT(worst(played.errors_ms, 20 * 30, 20 * 60), 1) << ppm;
  }
}

TEST(UwbClock, JumpsAndStartsAgain) {
  const auto ahead = [](TimeNs t) { return t < 5 * kS ? t : t + 600 * kS; };
  const auto anew = [](TimeNs t) { return t < 5 * kS ? 900 * kS + t : t - 5 * kS; };
  for (const auto& device : {std::function<TimeNs(TimeNs)>(ahead), {anew}}) {
    const Played played = play("nlink", 200, device);
    EXPECT_EQ(played.restarts, 1);
    EXPECT_LT(worst(played.errors_ms, 50, 100), 2);
    EXPECT_LT(worst(played.errors_ms, 110, 200), 2);
  }
}

}  // namespace
}  // namespace vir
