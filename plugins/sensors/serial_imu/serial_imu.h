#pragma once
/// Sensor "serial_imu": readings of an IMU on a serial port, TCP or UDP.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device_sensor.h"
#include "imu_options.h"
#include "imu_parser.h"
#include "vir/geometry/axes.h"

namespace vir {

/// Gives a CObservationIMU per reading (label of the section, `IMU0` if none is set): specific
/// force and rates in body axes.
class SerialImu : public DeviceSensor {
  DEFINE_GENERIC_SENSOR(SerialImu)
 public:
  SerialImu();
  ~SerialImu() override;

  void describe(OptionVisitor& v) override;
  std::vector<std::pair<std::string, long>> counters() const override;

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;
  const ByteSourceOptions& port() const override { return options_.source; }
  void begin() override;
  void forgetHalfMessages() override { parser_->reset(); }
  void take(const std::uint8_t* bytes, std::size_t size, TimeNs arrival) override;
  void converse(double now_s) override;
  long understood() const override { return parser_->counters().readings; }
  std::string whyNothing() const override;

 private:
  void emit(const serial_imu::ImuReading& reading, TimeNs arrival);
  TimeNs stampOf(const serial_imu::ImuReading& reading, TimeNs arrival);

  serial_imu::ImuOptions options_;
  Mat3 R_B_S_ = Mat3::Identity();  ///< S: the sensor's axes
  std::unique_ptr<serial_imu::ImuParser> parser_;
  TimeNs clock_wrap_ = 0;
  std::vector<serial_imu::ImuReading> readings_;
  TimeNs last_stamp_ = 0;
  long restarts_told_ = 0, given_ = 0;
};

}  // namespace vir
