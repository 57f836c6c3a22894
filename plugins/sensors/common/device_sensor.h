#pragma once
/// What drivers of devices that send bytes share: the port, its reopening, and what is said of it.
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/system/COutputLogger.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "byte_source.h"
#include "report_queue.h"
#include "vir/core/device_clock.h"
#include "vir/core/time.h"
#include "vir/roles/live_source.h"

namespace vir {

/// initialize() throws DeviceError if the device is not there; later on it is opened again and
/// doProcess(), which takes at most some 20 ms, does not throw.
class DeviceSensor : public mrpt::hwdrivers::CGenericSensor,
                     public mrpt::system::COutputLogger,
                     public roles::LiveSource {
 public:
  // CGenericSensor
  void initialize() final;
  void doProcess() final;

  // LiveSource
  bool connected() const final;
  std::vector<roles::SensorMessage> takeMessages() final;

 protected:
  using Counts = std::vector<std::pair<std::string, long>>;

  /// `label` is taken where the ini sets none.
  DeviceSensor(const std::string& driver, std::string label);
  /// Reads the driver's keys (describe()) and the label; a driver checks its own afterwards.
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;

  virtual const ByteSourceOptions& port() const = 0;
  /// Everything as new, before the port is opened.
  virtual void begin() = 0;
  /// The connection was made anew: what came last may be half a message.
  virtual void forgetHalfMessages() = 0;
  virtual void take(const std::uint8_t* bytes, std::size_t size, TimeNs arrival) = 0;
  /// After what came has been taken. `now_s`: of a steady clock.
  virtual void converse(double /*now_s*/) {}
  /// Messages understood since begin().
  virtual long understood() const = 0;
  /// Why bytes came for long of which none was understood, and what to look at.
  virtual std::string whyNothing() const = 0;

  /// The device's time on the clock of the host. A clock is begun where there is none, `wrap` being
  /// where its numbers begin anew (0: never).
  TimeNs onHostClock(TimeNs device_time, TimeNs arrival, TimeNs wrap);
  void forgetClock() { clock_.reset(); }
  /// Counts of the port and of the device's clock that are not zero.
  void addPortCounts(Counts* counts) const;

  ByteSource& source() { return *source_; }
  const ByteSource& source() const { return *source_; }
  const DeviceClock* clock() const { return clock_.get(); }
  ReportQueue reports_;

 private:
  void noteReopening();
  void noteNothingUnderstood(double now_s);

  std::string default_label_;
  std::unique_ptr<ByteSource> source_;
  std::unique_ptr<DeviceClock> clock_;
  long reopened_ = 0, understood_ = 0;
  double understood_s_ = 0;  // when the last message was understood, steady clock
  std::uint64_t bytes_then_ = 0;
};

/// Those that are not zero.
template <std::size_t N>
void addCounts(const std::pair<const char*, long> (&more)[N],
               std::vector<std::pair<std::string, long>>* counts) {
  for (const auto& [name, n] : more) {
    if (n != 0) counts->emplace_back(name, n);
  }
}

}  // namespace vir
