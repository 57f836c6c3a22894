#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/time.h"

namespace vir::live {

struct FoxgloveServerOptions {
  std::string name = "vir-slam";
  int max_clients = 8;  ///< at a time; who comes then is refused
  std::string token;    ///< clients must come to `ws://host:port/?token=...`; empty: none is asked
  /// A client that has more than so much to read gets nothing more until it has read [byte].
  std::size_t most_pending = 4 << 20;
};

/// Names and values that clients may read.
using FoxgloveParameters = std::vector<std::pair<std::string, std::string>>;

/// Sends messages to Foxglove and whoever else speaks its WebSocket protocol, version 1
/// (https://github.com/foxglove/ws-protocol). Works in a thread of its own and never waits for a
/// client: one that is slow loses messages, which are counted. Any thread.
class FoxgloveServer {
 public:
  /// Listens on `address`:`port`; port 0 takes a free one. Throws std::runtime_error naming both.
  FoxgloveServer(const std::string& address, int port, FoxgloveServerOptions options = {});
  ~FoxgloveServer();
  FoxgloveServer(const FoxgloveServer&) = delete;
  FoxgloveServer& operator=(const FoxgloveServer&) = delete;

  struct Channel {
    std::string topic;
    std::string encoding;         ///< `cdr`, `json`
    std::string schema_name;      ///< `sensor_msgs/msg/Imu`, `foxglove.Log`
    std::string schema_encoding;  ///< `ros2msg`, `jsonschema`
    std::string schema;
    bool latched = false;  ///< who subscribes later gets the last message
  };
  /// Tells clients of it; the number of the channel for send().
  std::uint32_t advertise(const Channel& channel);
  /// Does anybody read it? What costs time to make need not be made otherwise.
  bool wanted(std::uint32_t channel) const;
  void send(std::uint32_t channel, TimeNs t, std::string message);
  void setParameters(FoxgloveParameters parameters);

  int port() const;
  std::size_t clients() const;
  /// Connections not taken: too many, without the token, or of another protocol.
  long refused() const;
  /// Messages that slow clients did not get.
  long dropped() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::live
