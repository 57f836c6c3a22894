#include "serial_imu.h"

#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/obs/CObservationIMU.h>

#include <stdexcept>

#include "vir/core/settings.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(SerialImu, vir)

namespace {

constexpr TimeNs kTick = 100;  // of MRPT's clock

}  // namespace

SerialImu::SerialImu() : DeviceSensor("SerialImu", rawlog::kImuLabel) {}
SerialImu::~SerialImu() = default;

void SerialImu::describe(OptionVisitor& v) { serial_imu::describe(v, options_); }

void SerialImu::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                          const std::string& section) {
  DeviceSensor::loadConfig_sensorSpecific(config, section);
  try {
    R_B_S_ = axesRotation(options_.axes);
  } catch (const std::invalid_argument& e) {
    throw SettingsError({"ini", 0}, section, "axes", e.what());
  }
}

void SerialImu::begin() {
  parser_ = serial_imu::makeParser(options_.protocol, options_.limits, options_.mavlink);
  restarts_told_ = given_ = 0;
}

void SerialImu::take(const std::uint8_t* bytes, std::size_t size, TimeNs arrival) {
  readings_.clear();
  parser_->feed(bytes, size, &readings_);
  for (const serial_imu::ImuReading& reading : readings_) emit(reading, arrival);
}

void SerialImu::converse(double /*now_s*/) {
  if (clock() == nullptr) return;
  if (clock()->restarts() != restarts_told_) {
    restarts_told_ = clock()->restarts();
    reports_.say(
        LogLevel::warning,
        port().port + ": the device started again, or a clock was set; its stamps are fitted anew");
  }
  if (clock()->driftKnown()) {
    reports_.once("drift", LogLevel::info,
                  port().port + ": the device's clock is off by " +
                      std::to_string(clock()->driftPpm()) + " ppm");
  }
}

std::string SerialImu::whyNothing() const {
  if (options_.protocol == "mavlink" && parser_->counters().incomplete > 0) {
    return "no reading; its HIGHRES_IMU messages do not mark accelerometer and gyro as updated";
  }
  std::string why =
      "no reading; is baud = " + std::to_string(port().baud) + " right, and the protocol?";
  if (options_.protocol == "mavlink") {
    why += " Does the autopilot send HIGHRES_IMU (or SCALED_IMU) on this link?";
  }
  return why;
}

TimeNs SerialImu::stampOf(const serial_imu::ImuReading& reading, TimeNs arrival) {
  TimeNs t = arrival;
  if (options_.stamp == "device") {
    const TimeNs wrap = parser_->clockWrap();
    if (wrap != clock_wrap_) forgetClock();
    clock_wrap_ = wrap;
    t = onHostClock(reading.device_time, arrival, wrap);
  }
  t -= fromSeconds(options_.latency_s);
  last_stamp_ = std::max(last_stamp_ + kTick, t);
  return last_stamp_;
}

void SerialImu::emit(const serial_imu::ImuReading& reading, TimeNs arrival) {
  const ImuSample sample{stampOf(reading, arrival), R_B_S_ * Vec3(reading.gyro_rad_s.data()),
                         R_B_S_ * Vec3(reading.acc_m_s2.data())};
  ++given_;
  appendObservation(rawlog::toObservation(sample, m_sensorLabel));
}

std::vector<std::pair<std::string, long>> SerialImu::counters() const {
  Counts out = {{"imu_readings", given_}};
  if (!parser_) return out;
  const serial_imu::ParserCounters& c = parser_->counters();
  addCounts({{"messages", c.messages},
             {"implausible_readings", c.implausible},
             {"incomplete_readings", c.incomplete},
             {"lost_messages", c.lost},
             {"corrupt_messages", c.corrupt},
             {"other_messages", c.ignored},
             {"other_text", c.other_text},
             {"skipped_bytes", static_cast<long>(c.skipped_bytes)}},
            &out);
  addPortCounts(&out);
  return out;
}

}  // namespace vir
