#pragma once
/// Sensor "serial_imu": readings of an IMU on a serial port, TCP or UDP.
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/system/COutputLogger.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "byte_source.h"
#include "imu_options.h"
#include "imu_parser.h"
#include "report_queue.h"
#include "vir/core/device_clock.h"
#include "vir/pipeline/live_source.h"

namespace vir {

/// Gives a CObservationIMU per reading (label of the section, `IMU0` if none is set): specific
/// force and rates in body axes. initialize() throws DeviceError if the device is not there; later
/// on it is opened again and doProcess(), which takes at most some 20 ms, does not throw.
class SerialImu : public mrpt::hwdrivers::CGenericSensor,
                  public mrpt::system::COutputLogger,
                  public LiveSource {
  DEFINE_GENERIC_SENSOR(SerialImu)
 public:
  SerialImu();
  ~SerialImu() override;

  // CGenericSensor
  void initialize() override;
  void doProcess() override;

  // LiveSource
  void describe(OptionVisitor& v) override;
  bool connected() const override;
  std::vector<std::pair<std::string, long>> counters() const override;
  std::vector<std::string> takeMessages() override;

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;

 private:
  void noteReopening();
  void noteClock();
  void noteSilentParser(double now_s);
  void emit(const serial_imu::ImuReading& reading, TimeNs arrival);
  TimeNs stampOf(const serial_imu::ImuReading& reading, TimeNs arrival);

  serial_imu::ImuOptions options_;
  serial_imu::Axes axes_;
  std::unique_ptr<ByteSource> source_;
  std::unique_ptr<serial_imu::ImuParser> parser_;
  std::unique_ptr<DeviceClock> clock_;
  TimeNs clock_wrap_ = 0;
  ReportQueue reports_;
  std::vector<serial_imu::ImuReading> readings_;
  TimeNs last_stamp_ = 0;
  long reopened_ = 0, restarts_told_ = 0, given_ = 0, messages_seen_ = 0;
  double message_s_ = 0;
  std::uint64_t bytes_at_message_ = 0;
};

}  // namespace vir
