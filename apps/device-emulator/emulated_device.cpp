#include "emulated_device.h"

#include <cmath>
#include <stdexcept>

namespace vir::emulator {
namespace {

constexpr double kSettleS = 0.1;               // for a reader to set up and flush its port
constexpr std::size_t kMostPending = 1 << 16;  // bytes that a slow reader leaves waiting

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : ", ") + n;
  return text;
}

}  // namespace

EmulatedDevice::EmulatedDevice(const DeviceOptions& options)
    : options_(options),
      port_(options.link),
      random_(static_cast<std::uint64_t>(options.faults.seed)),
      next_change_(fromSeconds(options.faults.unplug_every_s)) {
  streaming_ = !options.shell;
}

TimeNs EmulatedDevice::deviceTime(TimeNs t) const {
  return t + fromSeconds(options_.clock_offset_s) +
         static_cast<TimeNs>(static_cast<double>(t) * options_.clock_drift_ppm * 1e-6);
}

bool EmulatedDevice::heard(double now_s) {
  if (!port_.hasReader()) {
    reader_since_s_ = -1;
    return false;
  }
  if (reader_since_s_ < 0) reader_since_s_ = now_s;
  return now_s >= reader_since_s_ + kSettleS;
}

void EmulatedDevice::push(const std::string& bytes) {
  pending_ += bytes;
  pending_.erase(0, port_.write(pending_));
}

void EmulatedDevice::send(std::string message, double now_s) {
  if (!port_.pluggedIn() || pull_at_s_ >= 0) {
    ++counts_.unplugged;
  } else if (!heard(now_s) || !streaming_) {
    ++counts_.unheard;
  } else if (pending_.size() > kMostPending) {
    ++counts_.overrun;
  } else {
    if (random_.uniform() < options_.faults.garbage) {
      std::string garbage(static_cast<std::size_t>(random_.uniform(1, 40)), '\0');
      for (char& c : garbage) c = static_cast<char>(static_cast<int>(random_.uniform(0, 256)));
      garbage += "\r\n";  // so that it spoils no line
      counts_.garbage_bytes += static_cast<long>(garbage.size());
      pending_ += garbage;
    }
    const bool damage = random_.uniform() < options_.faults.corrupt;
    if (damage) {
      const auto at =
          static_cast<std::size_t>(random_.uniform(0, static_cast<double>(message.size())));
      message[at] = static_cast<char>(message[at] ^ static_cast<int>(random_.uniform(1, 128)));
    }
    ++(damage ? counts_.damaged : counts_.sent);
    push(message);
  }
}

void EmulatedDevice::plugAndUnplug(TimeNs t, double now_s) {
  const FaultOptions& f = options_.faults;
  if (f.unplug_every_s <= 0 || t < next_change_) return;
  if (port_.pluggedIn()) {
    // First falls silent, so that what counts as sent has been read.
    if (pull_at_s_ < 0) pull_at_s_ = now_s + kSettleS;
    if (now_s < pull_at_s_) return;
    pull_at_s_ = -1;
    port_.pullOut();
    pending_.clear();
    ++counts_.unplugs;
    next_change_ = t + fromSeconds(f.unplug_for_s);
  } else {
    port_.plugIn();
    next_change_ = t + fromSeconds(f.unplug_every_s);
  }
}

void EmulatedDevice::service(TimeNs t, double now_s) {
  plugAndUnplug(t, now_s);
  if (!heard(now_s)) return;
  const std::string bytes = port_.read();
  if (!bytes.empty()) hear(bytes, now_s);
  if (!pending_.empty()) pending_.erase(0, port_.write(pending_));
}

/// The shell of a DWM1001: a prompt for every return, `lec` switches the stream on and off.
void EmulatedDevice::hear(const std::string& bytes, double) {
  if (!options_.shell) return;
  for (const char c : bytes) {
    if (c != '\r') {
      if (line_.size() < 80) line_ += c;
      continue;
    }
    if (line_ == "lec") streaming_ = !streaming_;
    push(line_ + "\r\ndwm> ");
    line_.clear();
  }
}

EmulatedRadio::EmulatedRadio(const DeviceOptions& options)
    : EmulatedDevice(options), encode_(rangeEncoder(options.protocol)) {
  if (encode_ == nullptr) {
    throw std::invalid_argument("no radio protocol is called " + options.protocol +
                                "; there are: " + joined(rangeProtocols()));
  }
  if (options.air.folder.empty()) return;
  if (options.protocol != "nlink") {
    throw std::invalid_argument("only radios with protocol nlink carry data over --air");
  }
  air_ = std::make_unique<EmulatedAir>(options.air, options.own_id);
}

void EmulatedRadio::service(TimeNs t, double now_s) {
  EmulatedDevice::service(t, now_s);
  if (!air_) return;
  for (const AirPacket& packet : air_->take()) {
    ++counts_.messages;
    ++data_in_;
    send(encodeNlinkData({options().own_id, packet.sender, packet.bytes}), now_s);
  }
}

void EmulatedRadio::play(TimeNs t, const RangeItem& range, double now_s) {
  ++counts_.messages;
  RangeMessage m;
  m.device_time = deviceTime(t);
  m.own_id = options().own_id;
  m.sequence = sequence_++;
  m.items = {range};
  std::string text;
  try {
    if (range.reference && options().protocol != "json") {
      throw std::invalid_argument("only json has differences");
    }
    text = encode_(m);
  } catch (const std::invalid_argument&) {
    ++counts_.refused;
    return;
  }
  if (options().protocol != "dwm1001_tlv") return send(text, now_s);
  waiting_.push_back(range);
  if (waiting_.size() > 12) {
    waiting_.pop_front();
    ++counts_.unheard;
  }
}

void EmulatedRadio::hear(const std::string& bytes, double now_s) {
  if (air_) {
    ++data_out_;
    air_->send(bytes);
    return;
  }
  if (options().protocol != "dwm1001_tlv") return EmulatedDevice::hear(bytes, now_s);
  for (const char c : bytes) {
    const bool asked = last_byte_ == '\x0C' && c == '\0';
    last_byte_ = c;
    if (!asked) continue;
    RangeMessage m;
    while (!waiting_.empty()) {
      // An answer names an anchor once.
      bool again = false;
      for (const RangeItem& item : m.items) again |= item.id == waiting_.front().id;
      if (again) break;
      m.items.push_back(waiting_.front());
      waiting_.pop_front();
      ++counts_.sent;
    }
    push(encode_(m));
  }
}

EmulatedImu::EmulatedImu(const DeviceOptions& options)
    : EmulatedDevice(options), encode_(imuEncoder(options.protocol)) {
  if (encode_ == nullptr) {
    throw std::invalid_argument("no IMU protocol is called " + options.protocol +
                                "; there are: " + joined(imuProtocols()));
  }
}

void EmulatedImu::play(TimeNs t, const ImuMessage& reading, double now_s) {
  ++counts_.messages;
  ImuMessage m = reading;
  m.device_time = deviceTime(t);
  m.sequence = sequence_++;
  send(encode_(m), now_s);
}

}  // namespace vir::emulator
