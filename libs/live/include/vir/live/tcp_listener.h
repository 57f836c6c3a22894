#pragma once
#include <string>

namespace vir::live {

/// Listens on a port for clients that may be many, slow or hostile: connections are made without
/// waiting, and the last descriptors of the process are left to the rest of the program.
class TcpListener {
 public:
  /// On `address`:`port`; port 0 takes a free one. Throws std::runtime_error naming both.
  TcpListener(const std::string& address, int port);
  ~TcpListener();
  TcpListener(const TcpListener&) = delete;
  TcpListener& operator=(const TcpListener&) = delete;

  int handle() const { return handle_; }  ///< to wait on
  int port() const { return port_; }

  enum class Accepted {
    client,  ///< `handle` is the caller's now; it does not block
    nobody,
    no_room,   ///< no descriptor: connections stay where they are; the caller should pause
    few_left,  ///< as `client`, but to be refused: it took one of the last descriptors
  };
  Accepted accept(int* handle) const;

 private:
  int handle_ = -1, port_ = 0;
};

}  // namespace vir::live
