#pragma once
/// Bytes of a device: serial port, TCP or UDP, opened again when it went away.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vir {

/// The device cannot be used: what() says which, why and what to do.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An open connection. Its functions never block, `wait` excepted.
class ByteChannel {
 public:
  virtual ~ByteChannel() = default;
  /// Bytes read, 0 = nothing there at the moment, -1 = the connection is gone (`why` says how).
  virtual long read(std::uint8_t* buffer, std::size_t size, std::string* why) = 0;
  /// False if not all of it could be written.
  virtual bool write(const std::uint8_t* bytes, std::size_t size) = 0;
  /// File descriptor to wait on.
  virtual int fd() const = 0;
  /// False while a connection is being set up in the background.
  virtual bool ready() { return true; }
};

/// Opens connections to one address, again and again.
class ChannelOpener {
 public:
  virtual ~ChannelOpener() = default;
  /// Throws DeviceError.
  virtual std::unique_ptr<ByteChannel> open() = 0;
  /// No bytes for long means a dead connection that should be made anew. (Not so for a serial port:
  /// opening it resets many boards.)
  virtual bool reopenWhenSilent() const { return false; }
};

/// A device file (serial port, pseudo-terminal). Throws DeviceError for a rate that is none.
std::unique_ptr<ChannelOpener> serialOpener(const std::string& path, int baud);
/// Throws DeviceError if the host's name cannot be resolved (done once, as it may take long).
std::unique_ptr<ChannelOpener> tcpOpener(const std::string& host, int port);
/// Listens on the interface with this `address`; empty = on this machine only, 0.0.0.0 = on all.
/// `from`: only datagrams of this host count; empty = anybody's.
std::unique_ptr<ChannelOpener> udpOpener(const std::string& address, int port,
                                         const std::string& from);

/// Datagrams to `host`:`port` and its answers; nobody else is listened to.
std::unique_ptr<ChannelOpener> udpPeerOpener(const std::string& host, int port);
/// To talk to one peer: `/dev/ttyUSB0` (any path), `tcp://host:port` or `udp://host:port`. Throws
/// DeviceError if `port` is of no such form.
std::unique_ptr<ChannelOpener> peerOpener(const std::string& port, int baud);

struct ByteSourceOptions {
  /// `/dev/ttyUSB0` (any path), `tcp://host:port`, `udp://:port` (datagrams of this machine) or
  /// `udp://address:port` (the interface to listen on, `0.0.0.0` = all), the latter two also with
  /// `?from=host` behind.
  std::string port;
  int baud = 115200;                             ///< serial ports only
  double silence_s = 5;                          ///< no bytes for so long is reported; 0 = never
  double first_retry_s = 0.2, last_retry_s = 5;  ///< back-off: doubles from the first to the last
};

class ByteSource {
 public:
  enum class State { closed, open, gone };

  /// Throws DeviceError if `port` is of no known form.
  explicit ByteSource(const ByteSourceOptions& options);
  ~ByteSource();

  /// Opens the device, for TCP waits up to 3 s. Throws DeviceError.
  void open();
  void close();

  /// What has arrived, at most `size` bytes; waits up to `wait_ms` for the first of them. When the
  /// device is gone it is opened again, with back-off; this is told by takeEvents(). Never throws
  /// once open() has returned.
  std::size_t read(std::uint8_t* buffer, std::size_t size, int wait_ms);
  /// False if the device is not there or does not take it (then nothing is tried again).
  bool write(const std::uint8_t* bytes, std::size_t size);
  bool write(const std::string& text);

  State state() const { return state_; }
  /// How often it was opened anew.
  long reopened() const { return reopened_; }
  /// Bytes read since open().
  std::uint64_t bytes() const { return bytes_; }
  /// Changes of the state since the last call, one line each.
  std::vector<std::string> takeEvents();

 private:
  void lose(const std::string& why);
  void tryToReopen();
  void checkSilence();

  ByteSourceOptions options_;
  std::unique_ptr<ChannelOpener> opener_;
  std::unique_ptr<ByteChannel> channel_;
  State state_ = State::closed;
  std::vector<std::string> events_;
  double retry_s_ = 0, next_try_s_ = 0, last_byte_s_ = 0, connect_by_s_ = 0;  // steady clock
  bool silent_ = false;
  long reopened_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace vir
