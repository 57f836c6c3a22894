#include "byte_source.h"

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "vir/core/parse_number.h"
#include "vir/core/resource_usage.h"

namespace vir {
namespace {

constexpr double kConnectTimeoutS = 3;

void sleepMs(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// Host and port of "host:port"; IPv6 addresses in brackets.
void splitAddress(const std::string& port, const std::string& address, std::string* host,
                  int* number) {
  const std::size_t colon = address.rfind(':');
  if (colon != std::string::npos) {
    if (parseNumber(address.substr(colon + 1), number) && *number > 0 && *number < 65536) {
      *host = address.substr(0, colon);
      if (host->size() > 2 && host->front() == '[' && host->back() == ']') {
        *host = host->substr(1, host->size() - 2);
      }
      return;
    }
  }
  throw DeviceError("port = " + port + ": expected tcp://host:number or udp://:number");
}

/// Of a serial port or a TCP address; null for one of UDP, which listeners and peers open
/// differently.
std::unique_ptr<ChannelOpener> streamOpener(const std::string& port, int baud) {
  if (port.empty()) {
    throw DeviceError("port is not set: give a device file, tcp://host:number or udp://:number");
  }
  if (port.rfind("udp://", 0) == 0) return nullptr;
  if (port.rfind("tcp://", 0) == 0) {
    std::string host;
    int number = 0;
    splitAddress(port, port.substr(6), &host, &number);
    if (host.empty()) throw DeviceError("port = " + port + ": the host is missing");
    return tcpOpener(host, number);
  }
  if (port.find("://") != std::string::npos) {
    throw DeviceError("port = " + port + ": only tcp:// and udp:// are known, or a device file");
  }
  return serialOpener(port, baud);
}

std::unique_ptr<ChannelOpener> makeOpener(const ByteSourceOptions& o) {
  const std::string& port = o.port;
  if (auto stream = streamOpener(port, o.baud)) return stream;
  static const std::string kFrom = "?from=";
  const std::size_t from = port.find(kFrom);
  std::string host;
  int number = 0;
  splitAddress(port, port.substr(6, from == std::string::npos ? from : from - 6), &host, &number);
  return udpOpener(host, number, from == std::string::npos ? "" : port.substr(from + kFrom.size()));
}

}  // namespace

std::unique_ptr<ChannelOpener> peerOpener(const std::string& port, int baud) {
  if (auto stream = streamOpener(port, baud)) return stream;
  std::string host;
  int number = 0;
  splitAddress(port, port.substr(6), &host, &number);
  if (host.empty()) throw DeviceError("port = " + port + ": the host is missing");
  return udpPeerOpener(host, number);
}

ByteSource::ByteSource(const ByteSourceOptions& options)
    : options_(options), opener_(makeOpener(options)) {}

ByteSource::~ByteSource() = default;

void ByteSource::open() {
  close();
  channel_ = opener_->open();
  const double give_up = wallSeconds() + kConnectTimeoutS;
  std::string why;
  while (!channel_->ready()) {
    std::uint8_t none = 0;
    if (channel_->read(&none, 0, &why) < 0) {
      channel_.reset();
      throw DeviceError(options_.port + ": " + why);
    }
    if (wallSeconds() > give_up) {
      channel_.reset();
      throw DeviceError(options_.port + ": no answer; is the address right and the device on?");
    }
    sleepMs(10);
  }
  state_ = State::open;
  bytes_ = 0;
  reopened_ = 0;
  last_byte_s_ = wallSeconds();
  silent_ = false;
}

void ByteSource::close() {
  channel_.reset();
  state_ = State::closed;
}

void ByteSource::lose(const std::string& why) {
  channel_.reset();
  if (state_ == State::open) {
    events_.push_back(options_.port + ": " + why + "; trying to open it again");
    retry_s_ = options_.first_retry_s;
  } else {
    retry_s_ = std::min(2 * retry_s_, options_.last_retry_s);
  }
  state_ = State::gone;
  next_try_s_ = wallSeconds() + retry_s_;
}

void ByteSource::tryToReopen() {
  const double now = wallSeconds();
  if (!channel_) {
    if (now < next_try_s_) return;
    try {
      channel_ = opener_->open();
    } catch (const DeviceError&) {
      lose("");  // still not there: said already
      return;
    }
    connect_by_s_ = now + kConnectTimeoutS;
  }
  if (!channel_->ready()) {
    std::string why;
    std::uint8_t none = 0;
    if (channel_->read(&none, 0, &why) < 0 || now > connect_by_s_) lose("");
    return;
  }
  state_ = State::open;
  ++reopened_;
  last_byte_s_ = now;
  silent_ = false;
  events_.push_back(options_.port + ": open again");
}

void ByteSource::checkSilence() {
  if (options_.silence_s <= 0 || wallSeconds() < last_byte_s_ + options_.silence_s) return;
  if (opener_->reopenWhenSilent()) {
    lose("nothing has come for a while");
    return;
  }
  if (silent_) return;
  silent_ = true;
  events_.push_back(options_.port + ": nothing comes (device off, wrong port or wiring?)");
}

std::size_t ByteSource::read(std::uint8_t* buffer, std::size_t size, int wait_ms) {
  if (state_ == State::closed) return 0;
  if (state_ == State::gone) {
    tryToReopen();
    if (state_ != State::open) {
      sleepMs(std::min(wait_ms, 20));
      return 0;
    }
  }
  if (wait_ms > 0) {
    pollfd p{channel_->fd(), POLLIN, 0};
    ::poll(&p, 1, wait_ms);
  }
  std::string why;
  const long n = channel_->read(buffer, size, &why);
  if (n < 0) {
    lose(why);
    return 0;
  }
  if (n == 0) {
    checkSilence();
    return 0;
  }
  last_byte_s_ = wallSeconds();
  if (silent_) events_.push_back(options_.port + ": bytes come again");
  silent_ = false;
  bytes_ += static_cast<std::uint64_t>(n);
  return static_cast<std::size_t>(n);
}

bool ByteSource::write(const std::uint8_t* bytes, std::size_t size) {
  return state_ == State::open && channel_->write(bytes, size);
}

bool ByteSource::write(const std::string& text) {
  return write(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

std::vector<std::string> ByteSource::takeEvents() {
  std::vector<std::string> out;
  out.swap(events_);
  return out;
}

}  // namespace vir
