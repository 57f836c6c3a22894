/// The driver as it is used: loaded as a plugin, on a pseudo-terminal and on UDP.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationIMU.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "byte_fd.h"
#include "messages.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_paths.h"
#include "vir_test_pty.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using mrpt::hwdrivers::CGenericSensor;
using mrpt::obs::CObservationIMU;
using Readings = std::vector<CObservationIMU::Ptr>;

class ImuPlugin : public ::testing::Test {
 protected:
  void SetUp() override {
    roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_serial_imu.so");
  }
  CGenericSensor::Ptr sensor(const std::string& port, const std::string& more) {
    const auto s = roles::createSensor("SerialImu");
    s->loadConfig(
        mrpt::config::CConfigFileMemory(
            "[imu]\ndriver = SerialImu\nprocess_rate = 100\nport = " + port + "\n" + more + "\n"),
        "imu");
    return s;
  }
  test::TempFolder folder;
  test::Pty pty{folder / "tty"};
};

Readings collect(CGenericSensor& sensor, std::size_t n, int calls = 400) {
  Readings readings;
  for (int i = 0; i < calls && readings.size() < n; ++i) {
    sensor.doProcess();
    for (const auto& [t, object] : sensor.getObservations()) {
      readings.push_back(std::dynamic_pointer_cast<CObservationIMU>(object));
    }
  }
  return readings;
}

emulator::ImuMessage message(int i) {
  emulator::ImuMessage m;
  m.device_time = 5'000'000LL * i;
  m.sequence = static_cast<unsigned>(i);
  m.acc_m_s2 = {1, 2, 3};
  m.gyro_rad_s = {0.1, 0.2, 0.3};
  return m;
}

TEST_F(ImuPlugin, ObservationsCarryEverything) {
  const auto s = sensor(pty.path(), "protocol = text\naxes = x -y -z");
  s->initialize();
  pty.send(emulator::encodeImuText(message(0)) + emulator::encodeImuText(message(1)));
  const Readings readings = collect(*s, 2);
  ASSERT_EQ(readings.size(), 2u);
  using namespace mrpt::obs;
  const CObservationIMU& o = *readings[0];
  EXPECT_EQ(o.sensorLabel, "IMU0");
  EXPECT_NEAR(o.get(IMU_X_ACC), 1, 1e-6);
  EXPECT_NEAR(o.get(IMU_Y_ACC), -2, 1e-6);
  EXPECT_NEAR(o.get(IMU_Z_ACC), -3, 1e-6);
  EXPECT_NEAR(o.get(IMU_WX), 0.1, 1e-6);
  EXPECT_NEAR(o.get(IMU_WY), -0.2, 1e-6);
  EXPECT_NEAR(o.get(IMU_WZ), -0.3, 1e-6);
  EXPECT_FALSE(o.has(IMU_MAG_X));
  EXPECT_GT(readings[1]->timestamp, readings[0]->timestamp);
}

TEST_F(ImuPlugin, GoesOnAfterUnplugging) {
  const auto s = sensor(pty.path(), "protocol = binary\nsensorLabel = IMU1");
  s->initialize();
  pty.send(emulator::encodeImuBinary(message(0)));
  Readings readings = collect(*s, 1);
  ASSERT_EQ(readings.size(), 1u);
  EXPECT_EQ(readings[0]->sensorLabel, "IMU1");
  pty.pullOut();
  for (int i = 0; i < 20; ++i) EXPECT_NO_THROW(s->doProcess());
  pty.plugIn();
  readings.clear();
  for (int i = 1; i < 100 && readings.empty(); ++i) {
    pty.send(emulator::encodeImuBinary(message(i)));
    readings = collect(*s, 1, 10);
  }
  EXPECT_FALSE(readings.empty());
}

TEST_F(ImuPlugin, MavlinkOverUdp) {
  const int port = 24000 + ::getpid() % 8000;
  const auto s = sensor("udp://127.0.0.1:" + std::to_string(port), "protocol = mavlink");
  s->initialize();
  const ByteFd sender(::socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  for (int i = 0; i < 10; ++i) {
    const std::string frame = emulator::encodeMavlinkHighres(message(i));
    ::sendto(sender.get(), frame.data(), frame.size(), 0, reinterpret_cast<sockaddr*>(&to),
             sizeof to);
  }
  EXPECT_EQ(collect(*s, 10).size(), 10u);
}

TEST_F(ImuPlugin, MissingDeviceAndBadSettingsAreErrors) {
  EXPECT_THROW(sensor(pty.path(), "axes = x y -z"), std::exception);
  EXPECT_THROW(sensor(pty.path(), "protocol = morse"), std::exception);
  const auto s = sensor((folder / "nothing").string(), "");
  EXPECT_THROW(s->initialize(), std::exception);
}

}  // namespace
}  // namespace vir
