#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace vir::live {

/// Sends lines of text to everybody who connects (TCP). Never waits for a client: one that does not
/// read loses its connection. Any thread.
class LineServer {
 public:
  /// Listens on `address`:`port`; port 0 takes a free one. Throws std::runtime_error naming both.
  LineServer(const std::string& address, int port);
  ~LineServer();
  LineServer(const LineServer&) = delete;
  LineServer& operator=(const LineServer&) = delete;

  /// To all clients, those that have just connected included. `line` without its end.
  void send(const std::string& line);
  int port() const { return port_; }
  std::size_t clients() const;
  /// Connections closed because the client did not read.
  long clientsCutOff() const;

 private:
  void acceptWaiting();
  bool push(int client, std::string* pending);

  mutable std::mutex mutex_;
  int listening_ = -1, port_ = 0;
  std::map<int, std::string> clients_;  // what each has yet to be sent
  long cut_off_ = 0;
};

}  // namespace vir::live
