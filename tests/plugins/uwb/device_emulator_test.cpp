/// The emulator as a program, the drivers as plugins: nothing is lost between them.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <chrono>
#include <future>
#include <map>
#include <regex>
#include <thread>

#include "vir/core/host_clock.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir/roles/live_source.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using mrpt::hwdrivers::CGenericSensor;
using mrpt::obs::CObservationBeaconRanges;
using mrpt::obs::CObservationIMU;

constexpr TimeNs kMs = 1'000'000, kStart = 1'700'000'000'000 * kMs;

class DeviceEmulator : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"uwb", "serial_imu"}) {
      roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_" + name + ".so");
    }
  }

  /// IMU at 200 Hz, ranges to anchors 0 to 3 and robot 5 in turn at 20 Hz.
  std::string recording(double seconds) {
    const std::string file = (folder / "r.rawlog").string();
    rawlog::RawlogWriter writer(file);
    for (int i = 0; i < seconds * 200; ++i) {
      const TimeNs t = kStart + 5 * kMs * i;
      CObservationIMU imu;
      imu.sensorLabel = "IMU0";
      imu.timestamp = rawlog::toMrptTime(t);
      imu.set(mrpt::obs::IMU_X_ACC, 0.001 * i);
      for (const auto k : {mrpt::obs::IMU_Y_ACC, mrpt::obs::IMU_Z_ACC, mrpt::obs::IMU_WX,
                           mrpt::obs::IMU_WY, mrpt::obs::IMU_WZ}) {
        imu.set(k, 0.5);
      }
      writer.write(imu);
      if (i % 10 != 0) continue;
      CObservationBeaconRanges range;
      const int id = i / 10 % 5;
      range.sensorLabel = id == 4 ? "PEER" : "UWB0";
      range.timestamp = rawlog::toMrptTime(t);
      CObservationBeaconRanges::TMeasurement m;
      m.beaconID = id == 4 ? 5 : id;
      m.sensedDistance = static_cast<float>(1 + 0.01 * (i / 10));
      range.sensedData.push_back(m);
      writer.write(range);
    }
    writer.finish();
    return file;
  }

  CGenericSensor::Ptr sensor(const std::string& name, const std::string& ini) {
    const auto s = roles::createSensor(name);
    s->loadConfig(mrpt::config::CConfigFileMemory("[s]\ndriver = " + name +
                                                  "\nprocess_rate = 100\n" + ini + "\n"),
                  "s");
    // The port comes when the emulator has started.
    for (int i = 0; i < 200; ++i) {
      try {
        s->initialize();
        return s;
      } catch (const std::exception&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    }
    throw std::runtime_error("the emulator does not come up");
  }

  std::future<test::Outcome> emulate(const std::string& arguments) {
    return std::async(std::launch::async, [arguments] {
      return test::shell(test::quoted(test::buildDir() + "/bin/vir-device-emulator") + " " +
                         arguments);
    });
  }

  std::string link(const char* name) { return (folder / name).string(); }

  test::TempFolder folder;
};

/// The number behind "name": in the part of the summary about `device`.
long counted(const std::string& summary, const std::string& device, const std::string& name) {
  std::smatch match;
  const std::regex pattern("\"" + device + "\": \\{[^}]*\"" + name + "\": (\\d+)");
  return std::regex_search(summary, match, pattern) ? std::stol(match[1]) : -1;
}

bool over(const std::future<test::Outcome>& f) {
  return f.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

struct Got {
  std::vector<CObservationBeaconRanges::Ptr> ranges;
  std::vector<CObservationIMU::Ptr> readings;

  void take(CGenericSensor& s) {
    s.doProcess();
    for (const auto& [t, object] : s.getObservations()) {
      if (auto r = std::dynamic_pointer_cast<CObservationBeaconRanges>(object)) ranges.push_back(r);
      if (auto i = std::dynamic_pointer_cast<CObservationIMU>(object)) readings.push_back(i);
    }
  }
};

TEST_F(DeviceEmulator, EveryRadioProtocolLosesNothing) {
  const std::string rawlog = recording(1);
  for (const std::string protocol :
       {"dwm1001", "trek1000", "at_range", "qm33", "nlink", "dw1000_arduino", "json"}) {
    auto emulator = emulate(rawlog + " --linger 0.5 --uwb " + protocol + "=" + link("uwb"));
    const auto s = sensor("UwbSerial", "port = " + link("uwb") +
                                           "\nprotocol = auto\npeer_ids = 5\n"
                                           "anchor_ids = 0 1 2 3");
    Got got;
    while (!over(emulator)) got.take(*s);
    const test::Outcome outcome = emulator.get();
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_EQ(counted(outcome.text, "uwb", "messages"), 20);
    // An id of 5 is the sixth slot of a TREK1000: it goes out in a line of eight ranges.
    EXPECT_EQ(counted(outcome.text, "uwb", "sent"), 20) << outcome.text;
    EXPECT_EQ(got.ranges.size(), 20u) << protocol;
    int peers = 0;
    for (const auto& r : got.ranges) peers += r->sensorLabel == "PEER";
    EXPECT_EQ(peers, 4) << protocol;
  }
}

TEST_F(DeviceEmulator, EveryImuProtocolLosesNothing) {
  const std::string rawlog = recording(1);
  for (const std::string protocol : {"text", "binary", "mavlink", "mavlink_scaled"}) {
    auto emulator = emulate(rawlog + " --linger 0.5 --imu " + protocol + "=" + link("imu"));
    const auto s = sensor("SerialImu", "port = " + link("imu") + "\nprotocol = " +
                                           (protocol[0] == 'm' ? "mavlink" : protocol));
    Got got;
    while (!over(emulator)) got.take(*s);
    const test::Outcome outcome = emulator.get();
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_EQ(counted(outcome.text, "imu", "sent"), 200) << outcome.text;
    ASSERT_EQ(got.readings.size(), 200u) << protocol;
    for (std::size_t i = 1; i < got.readings.size(); ++i) {
      EXPECT_GT(got.readings[i]->timestamp, got.readings[i - 1]->timestamp);
    }
  }
}

TEST_F(DeviceEmulator, BinaryDwm1001IsAsked) {
  auto emulator = emulate(recording(2) + " --linger 0.5 --uwb dwm1001_tlv=" + link("uwb"));
  const auto s =
      sensor("UwbSerial", "port = " + link("uwb") + "\nprotocol = dwm1001_tlv\npoll_hz = 30");
  Got got;
  while (!over(emulator)) got.take(*s);
  const test::Outcome outcome = emulator.get();
  EXPECT_EQ(counted(outcome.text, "uwb", "sent"), static_cast<long>(got.ranges.size()));
  EXPECT_GT(got.ranges.size(), 30u);
}

TEST_F(DeviceEmulator, GarbageAndDamage) {
  auto emulator = emulate(recording(2) + " --linger 0.5 --garbage 0.5 --corrupt 0.2 --uwb nlink=" +
                          link("uwb") + " --imu binary=" + link("imu"));
  const auto uwb = sensor("UwbSerial", "port = " + link("uwb") + "\nprotocol = nlink");
  const auto imu = sensor("SerialImu", "port = " + link("imu") + "\nprotocol = binary");
  Got got;
  while (!over(emulator)) {
    got.take(*uwb);
    got.take(*imu);
  }
  const test::Outcome outcome = emulator.get();
  EXPECT_GT(counted(outcome.text, "imu", "damaged"), 20) << outcome.text;
  EXPECT_EQ(static_cast<long>(got.readings.size()), counted(outcome.text, "imu", "sent"));
  EXPECT_EQ(static_cast<long>(got.ranges.size()), counted(outcome.text, "uwb", "sent"));
}

TEST_F(DeviceEmulator, UnpluggedAndBack) {
  auto emulator = emulate(
      recording(6) + " --linger 0.5 --unplug-every 1.5 --unplug-for 0.5 --imu text=" + link("imu"));
  const auto s = sensor("SerialImu", "port = " + link("imu") + "\nprotocol = text");
  Got got;
  while (!over(emulator)) got.take(*s);
  const test::Outcome outcome = emulator.get();
  EXPECT_GE(counted(outcome.text, "imu", "unplugs"), 2) << outcome.text;
  EXPECT_GT(counted(outcome.text, "imu", "sent"), 400) << outcome.text;
  EXPECT_EQ(static_cast<long>(got.readings.size()), counted(outcome.text, "imu", "sent"))
      << outcome.text;
}

TEST_F(DeviceEmulator, WrongUse) {
  EXPECT_EQ(emulate("nothing.rawlog").get().code, 2);
  EXPECT_EQ(emulate("--help").get().code, 0);
  EXPECT_EQ(emulate("nothing.rawlog --uwb dwm1001").get().code, 1);
  EXPECT_EQ(emulate(recording(1) + " --uwb morse").get().code, 2);
  EXPECT_EQ(emulate(recording(1) + " --uwb json --wait 0.2").get().code, 1);
  EXPECT_EQ(emulate(recording(1) + " --uwb json --air " + link("air")).get().code, 2);
  EXPECT_EQ(emulate(recording(1) + " --uwb nlink --own-id 256").get().code, 2);
  const std::string no_folder = recording(1);
  EXPECT_EQ(emulate(no_folder + " --uwb nlink --air " + no_folder).get().code, 1);
}

/// Two radios, each a process of its own: what the driver of one writes comes out of the other.
TEST_F(DeviceEmulator, RadiosCarryWhatRobotsTell) {
  const std::string rawlog = recording(3);
  std::vector<std::future<test::Outcome>> radios;
  std::vector<CGenericSensor::Ptr> drivers;
  for (const int id : {4, 5}) {
    const std::string name = link(id == 4 ? "four" : "five");
    radios.push_back(emulate(rawlog + " --linger 0.5 --own-id " + std::to_string(id) + " --air " +
                             link("air") + " --uwb nlink=" + name));
  }
  for (const int id : {4, 5}) {
    const std::string name = link(id == 4 ? "four" : "five");
    drivers.push_back(sensor("UwbSerial", "port = " + name +
                                              "\nprotocol = nlink\nown_id = " + std::to_string(id) +
                                              "\npeer_ids = " + std::to_string(9 - id) +
                                              "\ntell_hz = 20\nantenna_m = 0 0 0.5"));
  }
  auto* four = dynamic_cast<roles::LiveSource*>(drivers[0].get());
  auto* five = dynamic_cast<roles::LiveSource*>(drivers[1].get());
  EXPECT_TRUE(four->wantsStates());
  StateEstimate e;
  e.valid = true;
  e.covariance = 0.01 * Eigen::Matrix<double, 6, 6>::Identity();
  e.state.T_W_B.p = Vec3(1, 2, 3);
  std::vector<PeerPose> heard;
  while (!over(radios[0]) || !over(radios[1])) {
    e.state.t = hostNow();
    four->tell(e, {});
    for (const auto& driver : drivers) driver->doProcess();
    drivers[0]->getObservations();
    for (const auto& [t, object] : drivers[1]->getObservations()) {
      const auto o = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object);
      if (const auto pose = o ? rawlog::peerPoseOf(*o, "PEER") : std::nullopt) {
        heard.push_back(*pose);
      }
    }
  }
  for (auto& radio : radios) EXPECT_EQ(radio.get().code, 0);
  EXPECT_GT(heard.size(), 20u);
  for (const PeerPose& pose : heard) {
    EXPECT_EQ(pose.peer, 4);
    EXPECT_LT((pose.T_W_B.p - Vec3(1, 2, 3.5)).norm(), 1e-4);
  }
  std::map<std::string, long> counts;
  for (const auto& [name, n] : five->counters()) counts[name] = n;
  EXPECT_EQ(counts["heard_accepted"], static_cast<long>(heard.size()));
  EXPECT_EQ(counts["heard_damaged"], 0);
}

TEST_F(DeviceEmulator, OnlyARadioThatCarriesDataCanTell) {
  const std::pair<std::string, std::string> wrong[] = {
      {"protocol = json\nown_id = 3\ntell_hz = 5", "tell_hz: only a radio with protocol = nlink"},
      {"protocol = auto\nown_id = 3\ntell_hz = 5", "tell_hz: only a radio with protocol = nlink"},
      {"protocol = nlink\ntell_hz = 5", "own_id: must be this radio's id"},
      {"protocol = nlink\nown_id = 256\ntell_hz = 5", "own_id: must be this radio's id"},
      {"protocol = nlink\nown_id = 3\ntell_hz = 51", "tell_hz"},
      {"protocol = nlink\nown_id = 3\ntell_hz = x", "tell_hz"}};
  for (const auto& [ini, message] : wrong) {
    const auto s = roles::createSensor("UwbSerial");
    std::string said;
    try {
      s->loadConfig(
          mrpt::config::CConfigFileMemory("[s]\ndriver = UwbSerial\nprocess_rate = 100\nport = " +
                                          link("none") + "\n" + ini + "\n"),
          "s");
    } catch (const std::exception& e) {
      said = e.what();
    }
    EXPECT_NE(said.find(message), std::string::npos) << ini << ": " << said;
  }
}

}  // namespace
}  // namespace vir
