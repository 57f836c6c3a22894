#include "uwb_serial.h"

#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <chrono>
#include <stdexcept>

#include "live_logger.h"
#include "vir/core/settings.h"
#include "vir/pipeline/grabber_settings.h"
#include "vir/pipeline/mrpt_time.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(UwbSerial, vir)

namespace {

constexpr int kWaitMs = 20;
constexpr int kMostReads = 16;  // per doProcess()
constexpr double kMuteS = 5;    // bytes without a message for so long are worth a word
constexpr std::uint64_t kMuteBytes = 500;
constexpr const char* kPeerLabel = "PEER";

/// For intervals: time-outs of the dialogue.
double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

TimeNs hostTime() { return fromMrptTime(mrpt::Clock::now()); }

}  // namespace

UwbSerial::UwbSerial() : COutputLogger("UwbSerial") {
  m_sensorLabel = "UWB0";
  reports_.setSink(sinkOf(this));
}

UwbSerial::~UwbSerial() = default;

void UwbSerial::describe(OptionVisitor& v) { uwb::describe(v, options_); }

void UwbSerial::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                          const std::string& section) {
  readGrabberSection(config, section, [this](OptionVisitor& v) { describe(v); });
  setLoggerName(section);
  // MRPT's word for a label that is not set.
  if (m_sensorLabel.empty() || m_sensorLabel == "UNNAMED_SENSOR") m_sensorLabel = "UWB0";
  readIds(section);
  if (options_.limits.min_m >= options_.limits.max_m) {
    throw SettingsError({"ini", 0}, section, "min_range_m", "must be below max_range_m");
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

void UwbSerial::initialize() {
  m_state = ssInitializing;
  source_ = std::make_unique<ByteSource>(options_.source);
  parser_ = uwb::makeParser(options_.protocol, options_.limits);
  clock_.reset();
  polling_.reset();
  if (options_.protocol == "dwm1001_tlv") {
    polling_ = std::make_unique<uwb::TlvPolling>(options_.poll_hz);
  }
  dwm1001_.restart();
  given_.clear();
  last_device_time_.reset();
  known_protocol_.clear();
  reopened_ = messages_seen_ = 0;
  bytes_at_message_ = 0;
  source_->open();
  message_s_ = steadySeconds();
  m_state = ssWorking;
}

void UwbSerial::doProcess() {
  if (!source_) throw std::logic_error("UwbSerial: doProcess() before initialize()");
  std::uint8_t buffer[4096];
  for (int i = 0; i < kMostReads; ++i) {
    const std::size_t n = source_->read(buffer, sizeof buffer, i == 0 ? kWaitMs : 0);
    const TimeNs arrival = hostTime();
    noteReopening();
    if (n == 0) break;
    take(buffer, n, arrival);
  }
  const double now_s = steadySeconds();
  noteSilentParser(now_s);
  converse(now_s);
  for (const std::string& event : source_->takeEvents()) reports_.say(LogLevel::warning, event);
}

void UwbSerial::noteReopening() {
  if (source_->reopened() == reopened_) return;
  reopened_ = source_->reopened();
  parser_->reset();
  dwm1001_.restart();
}

void UwbSerial::take(const std::uint8_t* bytes, std::size_t size, TimeNs arrival) {
  dwm1001_.hear(bytes, size);
  readings_.clear();
  parser_->feed(bytes, size, &readings_);
  noteProtocol();
  for (const uwb::RangeReading& reading : readings_) emit(reading, arrival);
}

void UwbSerial::noteProtocol() {
  const std::string name = parser_->name();
  if (name == known_protocol_) return;
  known_protocol_ = name;
  clock_.reset();
  last_device_time_.reset();
  if (options_.protocol != "auto") return;
  if (name != "auto") {
    reports_.say(LogLevel::info, options_.source.port + ": protocol recognised: " + name);
  }
}

/// Bytes but no messages: the user should know why no ranges come.
void UwbSerial::noteSilentParser(double now_s) {
  const long messages = parser_->counters().messages;
  if (messages != messages_seen_ || !connected()) {
    messages_seen_ = messages;
    message_s_ = now_s;
    bytes_at_message_ = source_->bytes();
    reports_.forget("mute");
    return;
  }
  const std::uint64_t bytes = source_->bytes() - bytes_at_message_;
  if (now_s < message_s_ + kMuteS || bytes < kMuteBytes) return;
  reports_.once("mute", LogLevel::warning,
                options_.source.port + ": " + std::to_string(bytes) +
                    " bytes came, but nothing that protocol " + options_.protocol +
                    " knows; is baud = " + std::to_string(options_.source.baud) +
                    " right, and the protocol?");
}

void UwbSerial::converse(double now_s) {
  if (!connected()) return;
  if (polling_) {
    const std::string question = polling_->step(now_s);
    if (!question.empty()) source_->write(question);
    return;
  }
  const std::string name = parser_->name();
  // A device that talks in another way is left alone.
  const bool mayBeDwm = name == "dwm1001" || (name == "auto" && source_->bytes() == 0);
  if (!options_.dialogue || !(mayBeDwm || dwm1001_.engaged())) return;
  if (name != "dwm1001" && name != "auto") return;
  const std::string words = dwm1001_.step(now_s, parser_->counters().messages);
  if (words.empty()) return;
  reports_.once("dialogue", LogLevel::info,
                options_.source.port + ": no ranges come; asking as one asks a DWM1001");
  source_->write(words);
}

std::optional<std::string> UwbSerial::labelOf(std::int64_t id) {
  if (id < 0 || id > INT32_MAX) {
    ++given_["dropped_id_too_large"];
    reports_.once("id " + std::to_string(id), LogLevel::warning,
                  "id " + std::to_string(id) + " is too large for a beacon's number; dropped");
    return std::nullopt;
  }
  if (peers_.count(id) > 0) return kPeerLabel;
  const bool all_are_anchors = anchors_.empty() && peers_.empty();
  if (all_are_anchors || anchors_.count(id) > 0) return m_sensorLabel;
  const bool keep = options_.unknown_ids == "anchor";
  ++given_[keep ? "unknown_id_taken_as_anchor" : "dropped_unknown_id"];
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
    if (!clock_) {
      DeviceClockOptions o;
      o.wrap = parser_->clockWrap();
      clock_ = std::make_unique<DeviceClock>(o);
    }
    // The ranges of one message have one time.
    if (reading.device_time != last_device_time_) {
      last_clock_stamp_ = clock_->stamp(*reading.device_time, arrival);
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
    ++given_["dropped_other_tag"];
    return;
  }
  const TimeNs t = stampOf(reading, arrival);
  const std::optional<std::string> label = labelOf(reading.responder);
  if (!label) return;
  auto obs = std::make_shared<mrpt::obs::CObservationBeaconRanges>();
  obs->timestamp = toMrptTime(t);
  obs->sensorLabel = *label;
  obs->minSensorDistance = static_cast<float>(options_.limits.min_m);
  obs->maxSensorDistance = static_cast<float>(options_.limits.max_m);
  obs->stdError = static_cast<float>(options_.std_error_m);
  mrpt::obs::CObservationBeaconRanges::TMeasurement m;
  m.sensedDistance = static_cast<float>(reading.range_m);
  m.beaconID = static_cast<std::int32_t>(reading.responder);
  m.sensorLocationOnRobot =
      mrpt::poses::CPoint3D(options_.antenna_m[0], options_.antenna_m[1], options_.antenna_m[2]);
  obs->sensedData.push_back(m);
  ++given_[*label == kPeerLabel ? "peer_ranges" : "ranges"];
  appendObservation(obs);
}

bool UwbSerial::connected() const {
  return source_ != nullptr && source_->state() == ByteSource::State::open;
}

std::vector<std::pair<std::string, long>> UwbSerial::counters() const {
  std::vector<std::pair<std::string, long>> out(given_.begin(), given_.end());
  if (!parser_) return out;
  const uwb::ParserCounters& c = parser_->counters();
  const std::pair<const char*, long> more[] = {
      {"messages", c.messages},
      {"failed_measurements", c.failed},
      {"implausible_ranges", c.implausible},
      {"corrupt_messages", c.corrupt},
      {"fragments", c.fragments},
      {"other_messages", c.ignored},
      {"other_text", c.other_text},
      {"device_errors", c.device_errors},
      {"skipped_bytes", static_cast<long>(c.skipped_bytes)},
      {"reopened", reopened_},
      {"clock_restarts", clock_ ? clock_->restarts() : 0},
      {"clock_glitches", clock_ ? clock_->glitches() : 0}};
  for (const auto& [name, n] : more) {
    if (n != 0) out.emplace_back(name, n);
  }
  return out;
}

std::vector<std::string> UwbSerial::takeMessages() { return reports_.take(); }

}  // namespace vir
