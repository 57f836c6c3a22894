/// The driver as it is used: loaded as a plugin, on a pseudo-terminal.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <functional>

#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_paths.h"
#include "vir_test_pty.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using mrpt::hwdrivers::CGenericSensor;
using mrpt::obs::CObservationBeaconRanges;
using Ranges = std::vector<CObservationBeaconRanges::Ptr>;

class UwbPlugin : public ::testing::Test {
 protected:
  void SetUp() override {
    roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_uwb.so");
  }
  CGenericSensor::Ptr sensor(const std::string& more) {
    const auto s = roles::createSensor("UwbSerial");
    const std::string ini =
        "[uwb_front]\ndriver = UwbSerial\nprocess_rate = 100\nport = " + pty.path() + "\n" + more +
        "\n";
    s->loadConfig(mrpt::config::CConfigFileMemory(ini), "uwb_front");
    return s;
  }
  test::TempFolder folder;
  test::Pty pty{folder / "tty"};
};

/// Runs the sensor until `n` ranges are there, or `calls` went by.
Ranges collect(CGenericSensor& sensor, std::size_t n, int calls = 400) {
  Ranges ranges;
  for (int i = 0; i < calls && ranges.size() < n; ++i) {
    sensor.doProcess();
    for (const auto& [t, object] : sensor.getObservations()) {
      ranges.push_back(std::dynamic_pointer_cast<CObservationBeaconRanges>(object));
    }
  }
  return ranges;
}

const char* kLine =
    "DIST,3,AN0,0001,7.94,8.03,0.00,3.44,AN1,0002,0.00,8.00,0.00,2.12,AN2,0003,0.00,8.00,0.00,"
    "0.00\r\n";

TEST_F(UwbPlugin, ObservationsCarryEverything) {
  const auto s = sensor(
      "protocol = dwm1001\nanchor_ids = 0x0001\npeer_ids = 2\nstd_error_m = 0.07\n"
      "antenna_m = 0.1 -0.2 0.3\nsensorLabel = UWB7\nmax_range_m = 50");
  s->initialize();
  EXPECT_EQ(s->getState(), CGenericSensor::ssWorking);
  const TimeNs before = rawlog::fromMrptTime(mrpt::Clock::now());
  pty.send(kLine);
  const Ranges ranges = collect(*s, 2);
  const TimeNs after = rawlog::fromMrptTime(mrpt::Clock::now());
  ASSERT_EQ(ranges.size(), 2u);
  const bool anchor_first = ranges[0]->sensorLabel == "UWB7";
  const auto& anchor = *ranges[anchor_first ? 0 : 1];
  const auto& peer = *ranges[anchor_first ? 1 : 0];
  EXPECT_EQ(anchor.sensorLabel, "UWB7");
  EXPECT_EQ(peer.sensorLabel, "PEER");
  ASSERT_EQ(anchor.sensedData.size(), 1u);
  EXPECT_EQ(anchor.sensedData[0].beaconID, 1);
  EXPECT_FLOAT_EQ(anchor.sensedData[0].sensedDistance, 3.44F);
  EXPECT_DOUBLE_EQ(anchor.sensedData[0].sensorLocationOnRobot.x(), 0.1);
  EXPECT_DOUBLE_EQ(anchor.sensedData[0].sensorLocationOnRobot.y(), -0.2);
  EXPECT_DOUBLE_EQ(anchor.sensedData[0].sensorLocationOnRobot.z(), 0.3);
  EXPECT_FLOAT_EQ(anchor.stdError, 0.07F);
  EXPECT_FLOAT_EQ(anchor.maxSensorDistance, 50);
  EXPECT_EQ(peer.sensedData.at(0).beaconID, 2);
  EXPECT_FLOAT_EQ(peer.sensedData[0].sensedDistance, 2.12F);
  for (const auto& r : ranges) {
    EXPECT_GE(rawlog::fromMrptTime(r->timestamp), before - 100);
    EXPECT_LE(rawlog::fromMrptTime(r->timestamp), after);
  }
}

TEST_F(UwbPlugin, UnknownIds) {
  const auto drops = sensor("protocol = auto\nanchor_ids = 1");
  drops->initialize();
  pty.send(kLine);
  EXPECT_EQ(collect(*drops, 2, 20).size(), 1u);

  test::Pty other(folder / "tty2");
  const auto keeps = roles::createSensor("uwb");
  keeps->loadConfig(
      mrpt::config::CConfigFileMemory("[u]\ndriver = UwbSerial\nprocess_rate = 100\nport = " +
                                      other.path() + "\nanchor_ids = 1\nunknown_ids = anchor"),
      "u");
  keeps->initialize();
  other.send(kLine);
  const Ranges ranges = collect(*keeps, 2, 20);
  ASSERT_EQ(ranges.size(), 2u);
  for (const auto& r : ranges) EXPECT_EQ(r->sensorLabel, "UWB0");
}

TEST_F(UwbPlugin, GoesOnAfterUnplugging) {
  const auto s = sensor("protocol = auto");
  s->initialize();
  pty.send(kLine);
  EXPECT_EQ(collect(*s, 2).size(), 2u);
  pty.send("DIST,1,AN0,0001,7.9");  // cut off by the unplugging
  for (int i = 0; i < 5; ++i) s->doProcess();
  pty.pullOut();
  for (int i = 0; i < 20; ++i) EXPECT_NO_THROW(s->doProcess());
  EXPECT_NE(s->getState(), CGenericSensor::ssError);
  pty.plugIn();
  Ranges ranges;
  // Nothing tells the test when the driver is back: it sends until an answer comes.
  for (int i = 0; i < 100 && ranges.size() < 2; ++i) {
    pty.send(kLine);
    ranges = collect(*s, 2, 10);
  }
  EXPECT_GE(ranges.size(), 2u);
}

TEST_F(UwbPlugin, AsksASilentDwm1001) {
  const auto s = sensor("protocol = dwm1001");
  s->initialize();
  std::string heard;
  for (int i = 0; i < 400 && heard.find("lec\r") == std::string::npos; ++i) {
    s->doProcess();
    heard += pty.received();
    if (heard == "\r\r") pty.send("\r\n\r\ndwm> ");
  }
  EXPECT_EQ(heard, "\r\rlec\r");
}

TEST_F(UwbPlugin, PollsInBinaryMode) {
  const auto s = sensor("protocol = dwm1001_tlv\npoll_hz = 50");
  s->initialize();
  std::string heard;
  for (int i = 0; i < 100 && heard.size() < 6; ++i) {
    s->doProcess();
    heard += pty.received();
  }
  EXPECT_EQ(heard.substr(0, 6), std::string("\x0C\x00\x0C\x00\x0C\x00", 6));
}

/// MRPT wraps what loadConfig() throws and keeps its text.
std::string complaint(const std::function<void()>& load) {
  try {
    load();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "none";
}

TEST_F(UwbPlugin, MissingDeviceAndBadSettingsAreErrors) {
  const auto s = sensor("protocol = auto");
  pty.pullOut();
  EXPECT_THROW(s->initialize(), std::exception);
  const std::pair<const char*, const char*> bad[] = {
      {"protocol = morse", "protocol = morse: not one of the choices"},
      {"anchor_ids = 1 2\npeer_ids = 2", "id 2 is in anchor_ids too"},
      {"anchor_ids = one", "`one` is no id"},
      {"min_range_m = 5\nmax_range_m = 5", "must be below max_range_m"},
      {"prot = auto", "prot: unknown key"}};
  for (const auto& [ini, text] : bad) {
    const char* settings = ini;
    EXPECT_NE(complaint([&] { sensor(settings); }).find(text), std::string::npos) << settings;
  }
}

}  // namespace
}  // namespace vir
