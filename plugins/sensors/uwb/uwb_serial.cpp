#include "uwb_serial.h"

#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <random>
#include <stdexcept>

#include "vir/core/resource_usage.h"
#include "vir/core/settings.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/range_differences.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(UwbSerial, vir)

UwbSerial::UwbSerial() : DeviceSensor("UwbSerial", rawlog::kRangeLabel) {}
UwbSerial::~UwbSerial() = default;

void UwbSerial::describe(OptionVisitor& v) { uwb::describe(v, options_); }

void UwbSerial::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                          const std::string& section) {
  DeviceSensor::loadConfig_sensorSpecific(config, section);
  readIds(section);
  if (options_.limits.min_m >= options_.limits.max_m) {
    throw SettingsError({"ini", 0}, section, "min_range_m", "must be below max_range_m");
  }
  if (options_.tell_hz > 0 && options_.protocol != "nlink") {
    throw SettingsError({"ini", 0}, section, "tell_hz",
                        "only a radio with protocol = nlink carries data to other robots");
  }
  if (options_.tell_hz > 0 && (options_.own_id < 0 || options_.own_id > 255)) {
    throw SettingsError({"ini", 0}, section, "own_id",
                        "must be this radio's id (0 to 255) with tell_hz: the others know the "
                        "robot by it");
  }
}

void UwbSerial::readIds(const std::string& section) {
  const auto read = [&](const char* key, const std::string& text) {
    try {
      return uwb::parseIds(text);
    } catch (const std::invalid_argument& e) {
      throw SettingsError({"ini", 0}, section, key, e.what());
    }
  };
  anchors_ = read("anchor_ids", options_.anchor_ids);
  peers_ = read("peer_ids", options_.peer_ids);
  for (const std::int64_t id : peers_) {
    if (anchors_.count(id) == 0) continue;
    throw SettingsError({"ini", 0}, section, "peer_ids",
                        "id " + std::to_string(id) + " is in anchor_ids too; it can be only one");
  }
}

void UwbSerial::begin() {
  parser_ = uwb::makeParser(options_.protocol, options_.limits);
  polling_.reset();
  if (options_.protocol == "dwm1001_tlv") {
    polling_ = std::make_unique<uwb::TlvPolling>(options_.poll_hz);
  }
  dwm1001_.restart();
  given_ = {};
  std::optional<std::uint16_t> own;
  if (options_.own_id >= 0 && options_.own_id <= UINT16_MAX) {
    own = static_cast<std::uint16_t>(options_.own_id);
  }
  inbox_ = std::make_unique<team::RadioInbox>(
      own, [this](LogLevel level, const std::string& text) { reports_.say(level, text); });
  teller_.reset();
  if (options_.tell_hz > 0) {
    const std::vector<double>& antenna = options_.antenna_m;
    teller_ = std::make_unique<team::RadioTeller>(*own, std::random_device()(), options_.tell_hz,
                                                  Vec3(antenna[0], antenna[1], antenna[2]));
  }
  last_device_time_.reset();
  protocol_ = parser_->name();
  choices_ = parser_->choices();
}

void UwbSerial::forgetHalfMessages() {
  parser_->reset();
  inbox_->forgetHalfMessages();
  dwm1001_.restart();
}

void UwbSerial::take(const std::uint8_t* bytes, std::size_t size, TimeNs arrival) {
  dwm1001_.hear(bytes, size);
  readings_.clear();
  parser_->feed(bytes, size, &readings_);
  noteProtocol();
  for (const uwb::RangeReading& reading : readings_) emit(reading, arrival);
  for (const uwb::NodeData& data : parser_->takeData()) hear(data, arrival);
}

void UwbSerial::tell(const StateEstimate& estimate, const std::vector<Anchor>& anchors) {
  if (!teller_ || !connected()) return;
  const auto packet = teller_->tell(estimate, anchors);
  if (!packet) return;
  ++(source().write(packet->data(), packet->size()) ? given_.told : given_.not_told);
}

void UwbSerial::hear(const uwb::NodeData& data, TimeNs arrival) {
  if (data.sender == options_.own_id) return;  // an echo
  if (peers_.count(data.sender) == 0) {
    ++given_.data_of_strangers;
    reports_.once("data " + std::to_string(data.sender), LogLevel::info,
                  "radio " + std::to_string(data.sender) +
                      ", which is not in peer_ids, sends data: not listened to");
    return;
  }
  const auto heard =
      inbox_->add(data.sender, data.bytes.data(), data.bytes.size(), arrival, wallSeconds());
  for (const team::HeardReport& report : heard) {
    appendObservation(rawlog::toObservation(report.pose, rawlog::kPeerLabel));
    for (const PeerBroadcast& anchor : report.anchors) {
      appendObservation(rawlog::toObservation(anchor, rawlog::kPeerLabel));
    }
  }
}

void UwbSerial::noteProtocol() {
  if (parser_->choices() == choices_) return;
  choices_ = parser_->choices();
  const std::string name = parser_->name();
  if (name == protocol_) return;
  protocol_ = name;
  forgetClock();
  last_device_time_.reset();
  if (name == "auto") return;
  reports_.say(LogLevel::info, port().port + ": protocol recognised: " + name);
}

std::string UwbSerial::whyNothing() const {
  return "nothing that protocol " + options_.protocol +
         " knows; is baud = " + std::to_string(port().baud) + " right, and the protocol?";
}

void UwbSerial::converse(double now_s) {
  if (!connected()) return;
  if (polling_) {
    const std::string question = polling_->step(now_s);
    if (!question.empty()) source().write(question);
    return;
  }
  // A device that talks in another way is left alone.
  const bool mayBeDwm = protocol_ == "dwm1001" || (protocol_ == "auto" && source().bytes() == 0);
  if (!options_.dialogue || !(mayBeDwm || dwm1001_.engaged())) return;
  if (protocol_ != "dwm1001" && protocol_ != "auto") return;
  const std::string words = dwm1001_.step(now_s, parser_->counters().messages);
  if (words.empty()) return;
  reports_.once("dialogue", LogLevel::info,
                port().port + ": no ranges come; asking as one asks a DWM1001");
  source().write(words);
}

std::optional<std::string> UwbSerial::labelOf(std::int64_t id) {
  if (id < 0 || id > INT32_MAX) {
    ++given_.id_too_large;
    reports_.once("id " + std::to_string(id), LogLevel::warning,
                  "id " + std::to_string(id) + " is too large for a beacon's number; dropped");
    return std::nullopt;
  }
  if (peers_.count(id) > 0) return rawlog::kPeerLabel;
  const bool all_are_anchors = anchors_.empty() && peers_.empty();
  if (all_are_anchors || anchors_.count(id) > 0) return m_sensorLabel;
  const bool keep = options_.unknown_ids == "anchor";
  ++(keep ? given_.unknown_id_kept : given_.unknown_id_dropped);
  reports_.once("id " + std::to_string(id), LogLevel::warning,
                "id " + std::to_string(id) + " is neither in anchor_ids nor in peer_ids: " +
                    (keep ? "taken as an anchor" : "its ranges are dropped"));
  if (!keep) return std::nullopt;
  return m_sensorLabel;
}

TimeNs UwbSerial::stampOf(const uwb::RangeReading& reading, TimeNs arrival) {
  const bool device =
      options_.stamp == "device" || (options_.stamp == "auto" && parser_->clockTrusted());
  TimeNs t = arrival;
  if (device && reading.device_time) {
    // The ranges of one message have one time.
    if (reading.device_time != last_device_time_) {
      last_clock_stamp_ = onHostClock(*reading.device_time, arrival, parser_->clockWrap());
    }
    last_device_time_ = reading.device_time;
    t = last_clock_stamp_;
  }
  t -= fromSeconds(options_.latency_s);
  last_stamp_ = std::max(last_stamp_, t);
  return last_stamp_;
}

void UwbSerial::emit(const uwb::RangeReading& reading, TimeNs arrival) {
  if (options_.own_id >= 0 && reading.own && *reading.own != options_.own_id) {
    ++given_.other_tag;
    return;
  }
  const TimeNs t = stampOf(reading, arrival);
  const std::optional<std::string> label = labelOf(reading.responder);
  if (!label) return;
  if (reading.reference) return emitDifference(reading, *label, t);
  const std::vector<double>& antenna = options_.antenna_m;
  const Range range{t, static_cast<std::uint64_t>(reading.responder), reading.range_m,
                    options_.std_error_m, Vec3(antenna[0], antenna[1], antenna[2])};
  ++(*label == rawlog::kPeerLabel ? given_.peer_ranges : given_.ranges);
  appendObservation(rawlog::toObservation(
      range, *label, rawlog::RadioReach{options_.limits.min_m, options_.limits.max_m}));
}

void UwbSerial::emitDifference(const uwb::RangeReading& reading, const std::string& label,
                               TimeNs t) {
  const std::optional<std::string> of_reference = labelOf(*reading.reference);
  if (!of_reference) return;
  // Where a robot is nobody knows well enough to take it for an anchor.
  if (label == rawlog::kPeerLabel || *of_reference == rawlog::kPeerLabel) {
    ++given_.differences_to_peers;
    return;
  }
  const std::vector<double>& antenna = options_.antenna_m;
  ++given_.differences;
  appendObservation(rawlog::differenceObservation(
      {t, static_cast<std::uint64_t>(reading.responder), reading.range_m, options_.std_error_m,
       Vec3(antenna[0], antenna[1], antenna[2]), static_cast<std::uint64_t>(*reading.reference)}));
}

std::vector<std::pair<std::string, long>> UwbSerial::counters() const {
  Counts out;
  addCounts({{"dropped_id_too_large", given_.id_too_large},
             {"dropped_other_tag", given_.other_tag},
             {"dropped_unknown_id", given_.unknown_id_dropped},
             {"peer_ranges", given_.peer_ranges},
             {"ranges", given_.ranges},
             {"unknown_id_taken_as_anchor", given_.unknown_id_kept}},
            &out);
  addCounts({{"differences", given_.differences},
             {"differences_to_peers_dropped", given_.differences_to_peers},
             {"data_of_strangers", given_.data_of_strangers},
             {"not_told", given_.not_told},
             {"told", given_.told}},
            &out);
  if (!parser_) return out;
  for (const auto& [name, count] : inbox_->counters()) out.emplace_back("heard_" + name, count);
  const uwb::ParserCounters& c = parser_->counters();
  addCounts({{"messages", c.messages},
             {"failed_measurements", c.failed},
             {"implausible_ranges", c.implausible},
             {"corrupt_messages", c.corrupt},
             {"fragments", c.fragments},
             {"other_messages", c.ignored},
             {"other_text", c.other_text},
             {"device_errors", c.device_errors},
             {"skipped_bytes", static_cast<long>(c.skipped_bytes)}},
            &out);
  addPortCounts(&out);
  return out;
}

}  // namespace vir
