#pragma once
/// Sensor "uwb": ranges of a UWB device on a serial port, TCP or UDP.
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/system/COutputLogger.h>

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "byte_source.h"
#include "dialogue.h"
#include "range_parser.h"
#include "report_queue.h"
#include "uwb_options.h"
#include "vir/core/device_clock.h"
#include "vir/pipeline/live_source.h"

namespace vir {

/// Gives a CObservationBeaconRanges per range: label of the section (`UWB0` if none is set) for
/// anchors, `PEER` for the ids in peer_ids. Ranges are as measured: no bias is taken off.
/// initialize() throws DeviceError if the device is not there; later on it is opened again and
/// doProcess(), which takes at most some 20 ms, does not throw.
class UwbSerial : public mrpt::hwdrivers::CGenericSensor,
                  public mrpt::system::COutputLogger,
                  public LiveSource {
  DEFINE_GENERIC_SENSOR(UwbSerial)
 public:
  UwbSerial();
  ~UwbSerial() override;

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
  void readIds(const std::string& section);
  void noteReopening();
  void take(const std::uint8_t* bytes, std::size_t size, TimeNs arrival);
  void noteProtocol();
  void noteSilentParser(double now_s);
  void converse(double now_s);
  void emit(const uwb::RangeReading& reading, TimeNs arrival);
  std::optional<std::string> labelOf(std::int64_t id);
  TimeNs stampOf(const uwb::RangeReading& reading, TimeNs arrival);

  uwb::UwbOptions options_;
  std::set<std::int64_t> anchors_, peers_;
  std::unique_ptr<ByteSource> source_;
  std::unique_ptr<uwb::RangeParser> parser_;
  std::unique_ptr<DeviceClock> clock_;
  uwb::Dwm1001Dialogue dwm1001_;
  std::unique_ptr<uwb::TlvPolling> polling_;
  ReportQueue reports_;
  std::map<std::string, long> given_;  ///< by name, and what was dropped behind the parser
  std::vector<uwb::RangeReading> readings_;
  std::optional<TimeNs> last_device_time_;
  TimeNs last_clock_stamp_ = 0, last_stamp_ = 0;
  std::string known_protocol_;
  long reopened_ = 0, messages_seen_ = 0;
  double message_s_ = 0;
  std::uint64_t bytes_at_message_ = 0;
};

}  // namespace vir
