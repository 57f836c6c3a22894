#pragma once
/// Sensor "uwb": ranges of a UWB device on a serial port, TCP or UDP.
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "device_sensor.h"
#include "dialogue.h"
#include "range_parser.h"
#include "uwb_options.h"
#include "vir/team/radio_messages.h"

namespace vir {

/// Gives a CObservationBeaconRanges per range: label of the section (`UWB0` if none is set) for
/// anchors, `PEER` for the ids in peer_ids. Ranges are as measured: no bias is taken off. What
/// these other robots send as data of their radios is given as their poses and anchors (labels.h).
class UwbSerial : public DeviceSensor {
  DEFINE_GENERIC_SENSOR(UwbSerial)
 public:
  UwbSerial();
  ~UwbSerial() override;

  void describe(OptionVisitor& v) override;
  std::vector<std::pair<std::string, long>> counters() const override;
  bool wantsStates() const override { return options_.tell_hz > 0; }
  void tell(const StateEstimate& estimate, const std::vector<Anchor>& anchors) override;

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;
  const ByteSourceOptions& port() const override { return options_.source; }
  void begin() override;
  void forgetHalfMessages() override;
  void take(const std::uint8_t* bytes, std::size_t size, TimeNs arrival) override;
  void converse(double now_s) override;
  long understood() const override { return parser_->counters().messages; }
  std::string whyNothing() const override;

 private:
  /// What became of the ranges behind the parser.
  struct Given {
    long ranges = 0, peer_ranges = 0;
    long differences = 0, differences_to_peers = 0;
    long told = 0, not_told = 0, data_of_strangers = 0;
    long id_too_large = 0, other_tag = 0, unknown_id_dropped = 0, unknown_id_kept = 0;
  };

  void readIds(const std::string& section);
  void noteProtocol();
  void hear(const uwb::NodeData& data, TimeNs arrival);
  void emit(const uwb::RangeReading& reading, TimeNs arrival);
  void emitDifference(const uwb::RangeReading& reading, const std::string& label, TimeNs t);
  std::optional<std::string> labelOf(std::int64_t id);
  TimeNs stampOf(const uwb::RangeReading& reading, TimeNs arrival);

  uwb::UwbOptions options_;
  std::set<std::int64_t> anchors_, peers_;
  std::unique_ptr<uwb::RangeParser> parser_;
  uwb::Dwm1001Dialogue dwm1001_;
  std::unique_ptr<uwb::TlvPolling> polling_;
  std::unique_ptr<team::RadioInbox> inbox_;
  std::unique_ptr<team::RadioTeller> teller_;
  Given given_;
  std::vector<uwb::RangeReading> readings_;
  std::optional<TimeNs> last_device_time_;
  TimeNs last_clock_stamp_ = 0, last_stamp_ = 0;
  std::string protocol_;  ///< parser_'s name
  long choices_ = 0;      ///< of parser_, when it had that name
};

}  // namespace vir
