#pragma once
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "vir/live/tcp_listener.h"

namespace vir::live {

struct LineServerOptions {
  int max_clients = 16;  ///< at a time; who comes then is told so and sent away
  std::string token;     ///< first line that a client must send; empty: none is asked for
};

/// Sends lines of text to everybody who connects (TCP). Never waits for a client: one that does not
/// read loses its connection. Connections are accepted by a thread of its own, so that they cost
/// the program no more than `max_clients` descriptors however many come. Any thread.
class LineServer {
 public:
  /// Listens on `address`:`port`; port 0 takes a free one. Throws std::runtime_error naming both.
  LineServer(const std::string& address, int port, LineServerOptions options = {});
  ~LineServer();
  LineServer(const LineServer&) = delete;
  LineServer& operator=(const LineServer&) = delete;

  /// To all clients, those that have just connected included. `line` without its end.
  void send(const std::string& line);
  int port() const { return listener_.port(); }
  /// Those that are sent lines.
  std::size_t clients() const;
  /// Connections not taken: too many, or without the token.
  long refused() const;

 private:
  struct Client {
    std::string to_send;  // what it has yet to be sent
    std::string said;     // of its first line, while the token is awaited
    bool admitted = false;
    double since_s = 0;  // steady clock
  };

  void serve();
  bool acceptWaiting();
  void hearNewcomers();
  /// What became of a client whose token is awaited.
  enum class Hearing { waiting, admitted, refused };
  Hearing hear(int handle, Client* client) const;
  void refuse(int handle, const char* why);
  bool push(int client, std::string* pending);

  const LineServerOptions options_;
  const TcpListener listener_;
  mutable std::mutex mutex_;
  int wake_ = -1;
  std::map<int, Client> clients_;
  long refused_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace vir::live
